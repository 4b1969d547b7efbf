from glob import glob

from setuptools import find_packages, setup

NODES = ["optimizer", "evaluator", "study", "replay", "control"]

setup(
    name="mobo",
    version="0.1.0",
    packages=find_packages(include=["mobo", "mobo.*"]),
    package_data={"mobo": ["fastdds.xml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/mobo"]),
        ("share/mobo", ["package.xml"]),
        ("share/mobo/environment", glob("environment/*")),  # sourced by setup.bash and setup.zsh: see colcon.pkg
        ("share/mobo/launch", glob("launch/*.py")),
    ],
    install_requires=["setuptools", "mobo-core"],
    zip_safe=True,
    author="The mobo developers",
    maintainer="The mobo developers",
    maintainer_email="mobo-maintainers@users.noreply.github.com",
    description="The nodes of mobo",
    license="Apache-2.0",
    entry_points={"console_scripts": [f"{node} = mobo.{node}:main" for node in NODES]},
)
