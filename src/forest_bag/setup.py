"""Build of forest_bag for colcon; pip users install the root pyproject.toml."""

from setuptools import find_packages, setup

package = "forest_bag"

setup(
    name=package,
    version="0.3.0",
    description="What is recorded: MCAP bags written, read, repaired, played, compared, converted",
    license="Apache-2.0",
    packages=find_packages(include=[package, f"{package}.*"]),
    package_data={package: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package}"]),
        (f"share/{package}", ["package.xml"]),
    ],
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "forest-bag = forest_bag.cli.main:main",
            "recorder_node = forest_bag.recorder_node:main",
            "step_player_node = forest_bag.step_player_node:main",
        ]
    },
)
