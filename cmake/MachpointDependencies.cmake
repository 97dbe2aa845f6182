# Every find_package of the project. MachpointConfig.cmake.in repeats them for
# the projects that use an installed Machpoint.

# Absent when tools/setup was not called, and then Kokkos is where CMake looks.
if(Machpoint_DEPENDENCIES)
  include("${Machpoint_DEPENDENCIES}" OPTIONAL)
endif()
include(MachpointKokkos)
message(STATUS "Kokkos ${Kokkos_VERSION} (${Kokkos_DEVICES}): ${Kokkos_DIR}")

if(Machpoint_ENABLE_MPI)
  set(MPI_CXX_SKIP_MPICXX ON) # the C++ bindings that MPI itself removed
  find_package(MPI REQUIRED COMPONENTS CXX)
endif()

if(Machpoint_ENABLE_HDF5)
  set(HDF5_PREFER_PARALLEL ${Machpoint_ENABLE_MPI})
  # FindHDF5 asks a C compiler wrapper, and knows no C without the language.
  enable_language(C)
  find_package(HDF5 REQUIRED COMPONENTS C)
  if(HDF5_IS_PARALLEL AND NOT Machpoint_ENABLE_MPI)
    message(
      FATAL_ERROR
        "This HDF5 (${HDF5_INCLUDE_DIRS}) is a parallel one and needs MPI. "
        "Set Machpoint_ENABLE_MPI=ON, or HDF5_ROOT to a serial HDF5, or "
        "Machpoint_ENABLE_HDF5=OFF.")
  endif()
endif()

find_package(nlohmann_json 3.11 REQUIRED)
find_package(CLI11 REQUIRED)
find_package(fmt REQUIRED)
if(Machpoint_ENABLE_TESTS)
  find_package(GTest REQUIRED)
endif()

if(Machpoint_CABANA STREQUAL "AUTO")
  find_package(Cabana 0.7 QUIET)
elseif(Machpoint_CABANA STREQUAL "EXTERNAL")
  find_package(Cabana 0.7 REQUIRED)
elseif(NOT Machpoint_CABANA STREQUAL "BUNDLED")
  message(FATAL_ERROR "Machpoint_CABANA is '${Machpoint_CABANA}'; it is "
                      "AUTO, EXTERNAL or BUNDLED.")
endif()
set(cabana "bundled")
if(Cabana_FOUND AND NOT Machpoint_CABANA STREQUAL "BUNDLED")
  if(Cabana_ENABLE_MPI OR NOT Machpoint_ENABLE_MPI)
    set(cabana "${Cabana_DIR}")
  elseif(Machpoint_CABANA STREQUAL "EXTERNAL")
    message(FATAL_ERROR "The Cabana in ${Cabana_DIR} was built without MPI. Set "
                        "Machpoint_ENABLE_MPI=OFF, or Machpoint_CABANA=BUNDLED.")
  endif()
endif()
message(STATUS "Cabana: ${cabana}")
