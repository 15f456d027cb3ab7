"""Build of forest_compile for colcon; pip users install the root pyproject.toml."""

from setuptools import find_packages, setup

package = "forest_compile"

setup(
    name=package,
    version="0.3.0",
    description="How model functions become fast: ordinary Python compiled to machine code",
    license="Apache-2.0",
    packages=find_packages(include=[package, f"{package}.*"]),
    package_data={package: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package}"]),
        (f"share/{package}", ["package.xml"]),
    ],
    zip_safe=False,
)
