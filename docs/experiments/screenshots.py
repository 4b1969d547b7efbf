"""The pictures of docs/analysis.md: a report's page in headless Chromium, as small PNGs.

    mobo report BAG -o report && python docs/experiments/screenshots.py report docs

Needs playwright (of the extra ``dev``) and Debian's chromium; writes ``analysis_*.png`` into the second folder.
"""

from __future__ import annotations

import io
import shutil
import sys
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

COLOURS = 112


def keep(page: Page, file: Path, width: int, selector: str = "") -> None:
    """Save what the page shows, or one element of it, ``width`` pixels wide."""
    target = page.locator(selector).first if selector else page
    with Image.open(io.BytesIO(target.screenshot())) as image:
        height = round(image.height * width / image.width)
        small = image.convert("RGB").resize((width, height), Image.Resampling.LANCZOS)
        small.quantize(COLOURS, Image.Quantize.MEDIANCUT, kmeans=1, dither=Image.Dither.NONE).save(file, optimize=True)
    print(f"{file}: {file.stat().st_size / 1000:.0f} kB")


def main(report: Path, folder: Path) -> None:
    """Take the pictures."""
    chromium = shutil.which("chromium") or sys.exit("no chromium")
    address = (report / "index.html").resolve().as_uri()
    flags = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=chromium, args=flags)

        def opened(width: int, height: int, scheme: str) -> Page:
            page = browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
            page.goto(address)
            page.wait_for_function("document.documentElement.dataset.ready")
            page.wait_for_timeout(1500)
            return page

        page = opened(1400, 1080, "light")
        keep(page, folder / "analysis_page.png", 940)
        page.locator("#structures").scroll_into_view_if_needed()
        page.wait_for_timeout(2000)
        keep(page, folder / "analysis_structures.png", 760, "#structures .gallery")
        page = opened(390, 1500, "dark")
        page.locator("#arm").scroll_into_view_if_needed()
        page.wait_for_timeout(800)
        keep(page, folder / "analysis_phone.png", 300, "#arm")
        browser.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
