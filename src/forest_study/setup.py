"""Build of forest_study for colcon; pip users install the root pyproject.toml."""

from setuptools import find_packages, setup

package = "forest_study"

setup(
    name=package,
    version="0.3.0",
    description="What happens when machine and control meet: demo, graph, studies, the process supervisor",
    license="Apache-2.0",
    packages=find_packages(include=[package, f"{package}.*"]),
    package_data={package: ["py.typed", "log_work/operators/*.yaml", "logs/templates/*.html"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package}"]),
        (f"share/{package}", ["package.xml"]),
    ],
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "forest-ident = forest_study.experiments.forest_ident_main:main",
            "forest-study = forest_study.cli:main",
            "delay_node = forest_study.delay_node:main",
        ]
    },
)
