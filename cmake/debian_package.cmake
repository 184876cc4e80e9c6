# The Debian package that scripts/package makes: programs, libraries, message definitions, launch files, manual pages and
# completion below /usr, where Debian's own ROS packages are, so that rosrun and roslaunch find it.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME measuring-machine)
set(CPACK_PACKAGE_CONTACT "measuring_machine maintainers <maintainers@users.noreply.github.com>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "errors of a small measuring machine: identified, explained, corrected")
set(CPACK_PACKAGE_DESCRIPTION
    "mm compares the model of a measuring machine or machine tool with measurements, names the physical effect that\n\
the model misses, and shows how the error falls when it is added. The nodes drive the machine, record sessions and\n\
publish corrected TF frames (ROS 1 Noetic).")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)  # the libraries, from the programs themselves
set(CPACK_DEBIAN_PACKAGE_DEPENDS "ros-message-runtime, ros-actionlib-msgs, ros-geometry-msgs, ros-sensor-msgs, ros-std-msgs, ros-std-srvs")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS
    "snakemake, weasyprint, xmlsec1, rosbash, python3-roslaunch, python3-rosservice, python3-std-srvs, python3-sensor-msgs, python3-geometry-msgs, python3-rostopic, python3-rosnode, ros-robot-state-publisher, rviz")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS linuxcnc-uspace)  # the module that linuxcnc_helper needs
set(CPACK_DEBIAN_PACKAGE_CONFLICTS multimail)  # has an mm of its own
include(CPack)
