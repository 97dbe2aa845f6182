# machpoint_add_steppers(target): adds the translation units of all enabled methods,
# bases and dimensions, and core/stepper_list.hpp, which lists them. Methods, bases and
# modules share much code, so a dimension is one unit: three, one for each basis, took
# g++ 12 nearly twice as long. nvcc, which takes minutes for a basis, gets these one by
# one, a unit of the time loop, and modules with other sources of the library, which
# presets join, as most of their time goes into headers. (Units of dimensions are large
# already.)

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

# machpoint_write_unit(name template): writes the unit that a template makes of the
# caller's variables.
function(machpoint_write_unit name template)
  configure_file("${PROJECT_SOURCE_DIR}/cmake/${template}"
                 "${PROJECT_BINARY_DIR}/steppers/${name}.cpp" @ONLY)
endfunction()

# machpoint_add_stepper_unit(target name): the unit of what STEPPERS instantiates, and
# of INCLUDES. Time steps run what it compiles.
function(machpoint_add_stepper_unit target name)
  machpoint_write_unit(${name} stepper.cpp.in)
  set(source "${PROJECT_BINARY_DIR}/steppers/${name}.cpp")
  target_sources(${target} PRIVATE "${source}")
  set_source_files_properties(
    "${source}" PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON
                           COMPILE_OPTIONS "${Machpoint_STEP_OPTIONS}")
endfunction()

function(machpoint_add_steppers target)
  machpoint_check_choice(Machpoint_DIMENSIONS 1 2 3)
  machpoint_check_choice(Machpoint_BASES linear quadratic cubic)
  set(METHODS "")
  foreach(method IN LISTS Machpoint_METHODS)
    string(APPEND METHODS "#include <core/method_${method}.hpp>\n")
  endforeach()
  set(STEPPER_LIST "")
  set(BASIS_LIST "")
  foreach(basis IN LISTS Machpoint_BASES)
    machpoint_camel_case(BASIS ${basis})
    string(APPEND BASIS_LIST " \\\n    X( ${BASIS} )")
  endforeach()
  foreach(DIM 1 2 3)
    # `list` and `schema` name the modules of every dimension.
    set(FACTORIES factories)
    if(NOT DIM IN_LIST Machpoint_DIMENSIONS)
      set(FACTORIES declarations)
    endif()
    machpoint_write_unit(modules_${DIM}d modules.cpp.in)
    set(INCLUDES "${METHODS}")
    if(DIM IN_LIST Machpoint_DIMENSIONS AND NOT Kokkos_ENABLE_CUDA)
      string(APPEND INCLUDES "#include \"modules_${DIM}d.cpp\"\n")
    else()
      target_sources(${target} PRIVATE "${PROJECT_BINARY_DIR}/steppers/modules_${DIM}d.cpp")
    endif()
    if(NOT DIM IN_LIST Machpoint_DIMENSIONS)
      continue()
    endif()
    set(STEPPERS "template class SceneRun<${DIM}>;\ntemplate class TimeLoop<${DIM}>;\n")
    if(Kokkos_ENABLE_CUDA)
      machpoint_add_stepper_unit(${target} time_loop_${DIM}d)
      set(STEPPERS "")
    endif()
    foreach(basis IN LISTS Machpoint_BASES)
      machpoint_camel_case(BASIS ${basis})
      foreach(method IN LISTS Machpoint_METHODS)
        machpoint_camel_case(METHOD ${method})
        string(APPEND STEPPERS "template std::unique_ptr<Simulation>\n"
               "makeSimulation<${DIM}, ${BASIS}, ${METHOD}>( const Json& );\n")
        string(APPEND STEPPER_LIST " \\\n    X( ${DIM}, ${BASIS}, ${METHOD} )")
      endforeach()
      if(Kokkos_ENABLE_CUDA)
        machpoint_add_stepper_unit(${target} ${basis}_${DIM}d)
        set(STEPPERS "")
      endif()
    endforeach()
    if(NOT Kokkos_ENABLE_CUDA)
      machpoint_add_stepper_unit(${target} steppers_${DIM}d)
    endif()
  endforeach()
  configure_file("${PROJECT_SOURCE_DIR}/cmake/stepper_list.hpp.in"
                 "${PROJECT_BINARY_DIR}/include/core/stepper_list.hpp" @ONLY)
endfunction()
