"""Hosts for tests: network namespaces on a bridge, whose links can be cut and lose packets.

Without root they are made in a user namespace of their own, where the kernel allows that.
"""

from __future__ import annotations

import functools
import os
import shutil
import subprocess
from collections.abc import Sequence

_TOOLS = ("unshare", "nsenter", "ip", "iptables")


class Hosts:
    """``count`` hosts, 10.77.0.1 and up, each with one link to the same bridge. A context manager.

    Each is held by a process that sleeps; the bridge is in a namespace of its own.
    """

    def __init__(self, count: int) -> None:
        self._holders: list[subprocess.Popen[bytes]] = []
        try:
            user = [] if os.geteuid() == 0 else ["--user", "--map-root-user"]
            self._switch = self._hold(["unshare", *user, "--net"])
            self._on_switch("ip", "link", "add", "bridge0", "type", "bridge", "mcast_snooping", "0")
            self._on_switch("ip", "link", "set", "bridge0", "up")
            self._hosts = [self._hold([*self._enter(self._switch), "unshare", "--net"]) for _ in range(count)]
            for i, holder in enumerate(self._hosts):
                port = ["type", "veth", "peer", "name", "eth0", "netns", str(holder.pid)]
                self._on_switch("ip", "link", "add", f"port{i}", *port)
                self._on_switch("ip", "link", "set", f"port{i}", "master", "bridge0", "up")
                self.run(i, "ip", "link", "set", "lo", "up")
                self.run(i, "ip", "address", "add", f"{address(i)}/24", "dev", "eth0")
                self.run(i, "ip", "link", "set", "eth0", "up")
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Hosts:
        """Return itself."""
        return self

    def __exit__(self, *error: object) -> None:
        """Remove the hosts."""
        self.close()

    def close(self) -> None:
        """Remove the hosts: with the last process in it, a namespace goes."""
        for holder in self._holders:
            holder.kill()
            holder.wait()

    def on(self, host: int) -> list[str]:
        """Return what goes before a command so that it runs on a host."""
        return self._enter(self._hosts[host])

    def run(self, host: int, *command: str) -> None:
        """Run a command on a host; it must succeed."""
        _run(*self.on(host), *command)

    def cut(self, host: int) -> None:
        """Cut the host's link."""
        self._on_switch("ip", "link", "set", f"port{host}", "down")

    def heal(self, host: int) -> None:
        """Mend the host's link."""
        self._on_switch("ip", "link", "set", f"port{host}", "up")

    def drop(self, host: int, *matching: str) -> None:
        """Let the host drop incoming packets that match, such as ``-m pkttype --pkt-type multicast``."""
        self.run(host, "iptables", "-A", "INPUT", "-i", "eth0", *matching, "-j", "DROP")

    def drop_nothing(self, host: int) -> None:
        """End all dropping."""
        self.run(host, "iptables", "-F", "INPUT")

    def _hold(self, inside: Sequence[str]) -> subprocess.Popen[bytes]:
        # It says so once it is inside.
        holder = subprocess.Popen([*inside, "sh", "-c", "echo; exec sleep infinity"], stdout=subprocess.PIPE)
        self._holders.append(holder)
        assert holder.stdout is not None
        if not holder.stdout.readline():
            raise RuntimeError(f"cannot enter a namespace: {' '.join(inside)}")
        return holder

    def _enter(self, holder: subprocess.Popen[bytes]) -> list[str]:
        user = [] if os.geteuid() == 0 else ["--user", "--preserve-credentials"]
        return ["nsenter", "--target", str(holder.pid), *user, "--net", "--"]

    def _on_switch(self, *command: str) -> None:
        _run(*self._enter(self._switch), *command)


def address(host: int) -> str:
    """Return the address of a host."""
    return f"10.77.0.{host + 1}"


RANDOM_5_PERCENT = ("-m", "statistic", "--mode", "random", "--probability", "0.05")
MULTICAST = ("-m", "pkttype", "--pkt-type", "multicast")


@functools.cache
def lacking() -> str:
    """Return what this machine lacks for hosts, or ""."""
    missing = [tool for tool in _TOOLS if shutil.which(tool) is None]
    if missing:
        return f"lacks {', '.join(missing)} (Debian: util-linux, iproute2, iptables)"
    try:
        with Hosts(1) as hosts:
            hosts.drop(0, *RANDOM_5_PERCENT)
            hosts.drop(0, *MULTICAST)
    except (OSError, RuntimeError, subprocess.CalledProcessError) as error:
        said = getattr(error, "stderr", None) or str(error)
        return f"lacks the right to make network namespaces, or iptables in them ({said.strip()[:200]})"
    return ""


def _run(*command: str) -> None:
    subprocess.run(command, check=True, capture_output=True, text=True, timeout=300)
