"""Build of forest_sim for colcon; pip users install the root pyproject.toml."""

from setuptools import find_packages, setup

package = "forest_sim"

setup(
    name=package,
    version="0.3.0",
    description="How the crane moves: hydraulics, manipulator, integrator, sensors, the simulator node",
    license="Apache-2.0",
    packages=find_packages(include=[package, f"{package}.*"]),
    package_data={package: ["py.typed", "pumps/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package}"]),
        (f"share/{package}", ["package.xml"]),
    ],
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "forest-sim = forest_sim.cli.main:main",
            "simulator_node = forest_sim.simulator_node:main",
            "commander_node = forest_sim.commander_node:main",
        ]
    },
)
