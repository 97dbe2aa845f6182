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

install(
  EXPORT MachpointTargets
  NAMESPACE Machpoint::
  DESTINATION "${package}")
configure_package_config_file(
  cmake/MachpointConfig.cmake.in
  "${PROJECT_BINARY_DIR}/MachpointConfig.cmake"
  INSTALL_DESTINATION "${package}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/MachpointConfigVersion.cmake"
                                 COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/MachpointConfig.cmake"
              "${PROJECT_BINARY_DIR}/MachpointConfigVersion.cmake"
        DESTINATION "${package}")
