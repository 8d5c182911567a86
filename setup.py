import os

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import find_packages, setup

PACKAGES = find_packages(os.path.join(os.path.dirname(os.path.abspath(__file__)), "src"))

# Types for those who use the package: py.typed says that it has them, the stubs are those of the C++ modules.
setup(**generate_distutils_setup(packages=PACKAGES, package_dir={"": "src"},
                                 package_data={"voxnav": ["py.typed", "*.pyi"]}))
