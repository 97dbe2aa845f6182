# Finds Kokkos and checks it against Machpoint_BACKEND. Alone in this file
# because tools/setup makes the same check before it builds a Kokkos.

# Ends with the words. What CMake has found would be found again, whatever
# Kokkos_ROOT says by then.
function(machpoint_refuse_kokkos)
  unset(Kokkos_DIR CACHE)
  string(JOIN "" words ${ARGN})
  message(FATAL_ERROR "${words}")
endfunction()

# No version here: Kokkos' own version file accepts one major at a time.
find_package(Kokkos QUIET)
if(NOT Kokkos_FOUND)
  machpoint_refuse_kokkos(
    "Kokkos was not found. Run tools/setup, or pass -D Kokkos_ROOT=PREFIX of one "
    "(4.6 up to and including 5.x).\n"
    "${Kokkos_NOT_FOUND_MESSAGE}")
endif()
if(Kokkos_VERSION VERSION_LESS 4.6 OR Kokkos_VERSION VERSION_GREATER_EQUAL 6)
  machpoint_refuse_kokkos(
    "The Kokkos in ${Kokkos_DIR} is ${Kokkos_VERSION}, and Machpoint takes "
    "4.6 up to and including 5.x. Run tools/setup, or pass "
    "-D Kokkos_ROOT=PREFIX of another.")
endif()

if(Machpoint_PRECISION STREQUAL "single" AND Kokkos_VERSION VERSION_LESS 4.7)
  # tools/setup would take the same one again: it knows no precision.
  machpoint_refuse_kokkos(
    "Machpoint_PRECISION is single, which takes Kokkos 4.7 or later; the one "
    "in ${Kokkos_DIR} is ${Kokkos_VERSION}. Pass -D Kokkos_ROOT=PREFIX of "
    "a later one.")
endif()

if(Machpoint_BACKEND AND NOT Machpoint_BACKEND MATCHES "^(CUDA|OPENMP|SERIAL)$")
  message(
    FATAL_ERROR "Machpoint_BACKEND is '${Machpoint_BACKEND}'; it is CUDA, "
                "OPENMP, SERIAL, or empty for Kokkos' default.")
endif()
if(Machpoint_BACKEND AND NOT Machpoint_BACKEND IN_LIST Kokkos_DEVICES)
  string(TOLOWER "${Machpoint_BACKEND}" preset)
  string(JOIN ", " offered ${Kokkos_DEVICES})
  machpoint_refuse_kokkos(
    "Machpoint_BACKEND is ${Machpoint_BACKEND}, but the Kokkos in "
    "${Kokkos_DIR} offers ${offered}. Run `tools/setup --preset "
    "${preset}`, or pass -D Kokkos_ROOT=PREFIX of one that was built "
    "with Kokkos_ENABLE_${Machpoint_BACKEND}=ON.")
endif()
