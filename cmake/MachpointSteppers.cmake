# machpoint_add_steppers(target): adds one translation unit for each enabled
# (dimension, basis), with all methods, and core/stepper_list.hpp, which lists them.
# Units compile in parallel, and in less memory than one; but three quarters of the
# code of a stepper are those of any other, so one unit for each method as well
# would take half as long again. Presets join other sources of the library, six to
# a unit, as most of the time goes into headers; these units are large already.

function(machpoint_camel_case out name)
  string(SUBSTRING "${name}" 0 1 head)
  string(SUBSTRING "${name}" 1 -1 tail)
  string(TOUPPER "${head}" head)
  set(${out} "${head}${tail}" PARENT_SCOPE)
endfunction()

# Each item of the list variable must be among the names that follow.
function(machpoint_check_choice variable)
  if(NOT ${variable})
    message(FATAL_ERROR "${variable} is empty; it takes of: ${ARGN}")
  endif()
  foreach(item IN LISTS ${variable})
    if(NOT item IN_LIST ARGN)
      message(FATAL_ERROR "${variable}: no '${item}'; it takes of: ${ARGN}")
    endif()
  endforeach()
endfunction()

function(machpoint_add_steppers target)
  machpoint_check_choice(Machpoint_DIMENSIONS 1 2 3)
  machpoint_check_choice(Machpoint_BASES linear quadratic cubic)
  set(STEPPER_LIST "")
  # Modules exist in every dimension: `list` and `schema` name them all.
  foreach(DIM 1 2 3)
    set(source "${PROJECT_BINARY_DIR}/steppers/modules_${DIM}d.cpp")
    configure_file("${PROJECT_SOURCE_DIR}/cmake/modules.cpp.in" "${source}"
                   @ONLY)
    target_sources(${target} PRIVATE "${source}")
    if(NOT Kokkos_ENABLE_CUDA)
      set_source_files_properties("${source}" PROPERTIES
                                  SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
  endforeach()
  foreach(DIM IN LISTS Machpoint_DIMENSIONS)
    foreach(basis IN LISTS Machpoint_BASES)
      machpoint_camel_case(BASIS ${basis})
      set(INCLUDES "")
      set(STEPPERS "")
      foreach(method IN LISTS Machpoint_METHODS)
        machpoint_camel_case(METHOD ${method})
        string(APPEND INCLUDES "#include <core/method_${method}.hpp>\n")
        string(APPEND STEPPERS "template std::unique_ptr<Simulation>\n"
               "makeSimulation<${DIM}, ${BASIS}, ${METHOD}>( const Json& );\n")
        string(APPEND STEPPER_LIST " \\\n    X( ${DIM}, ${BASIS}, ${METHOD} )")
      endforeach()
      set(source "${PROJECT_BINARY_DIR}/steppers/${basis}_${DIM}d.cpp")
      configure_file("${PROJECT_SOURCE_DIR}/cmake/stepper.cpp.in" "${source}"
                     @ONLY)
      target_sources(${target} PRIVATE "${source}")
      if(NOT Kokkos_ENABLE_CUDA)
        set_source_files_properties("${source}" PROPERTIES
                                    SKIP_UNITY_BUILD_INCLUSION ON)
      endif()
    endforeach()
  endforeach()
  configure_file("${PROJECT_SOURCE_DIR}/cmake/stepper_list.hpp.in"
                 "${PROJECT_BINARY_DIR}/include/core/stepper_list.hpp" @ONLY)
endfunction()
