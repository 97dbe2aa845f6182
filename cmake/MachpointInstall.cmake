# What `cmake --install` puts where, and the package file for find_package.
include(CMakePackageConfigHelpers)

set(headers "${CMAKE_INSTALL_INCLUDEDIR}/machpoint")
set(package "${CMAKE_INSTALL_LIBDIR}/cmake/Machpoint")
set(targets machpoint machpoint_core)
set(without_cabana PATTERN cabana EXCLUDE)
if(TARGET machpoint_cabana)
  list(APPEND targets machpoint_cabana)
  set(without_cabana "")
endif()

install(TARGETS ${targets} EXPORT MachpointTargets)
install(
  DIRECTORY core physics boundary drivers "${PROJECT_BINARY_DIR}/include/core"
  DESTINATION "${headers}"
  FILES_MATCHING
  PATTERN "*.hpp" ${without_cabana})

install(FILES LICENSE DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/machpoint")

install(
  EXPORT MachpointTargets
  NAMESPACE Machpoint::
  DESTINATION "${package}")
# Where find_package does not look: the build tree is no package.
set(made "${PROJECT_BINARY_DIR}/to_install")
configure_package_config_file(
  cmake/MachpointConfig.cmake.in
  "${made}/MachpointConfig.cmake"
  INSTALL_DESTINATION "${package}")
write_basic_package_version_file("${made}/MachpointConfigVersion.cmake"
                                 COMPATIBILITY SameMinorVersion)
install(FILES "${made}/MachpointConfig.cmake"
              "${made}/MachpointConfigVersion.cmake"
        DESTINATION "${package}")
