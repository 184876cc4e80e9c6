# The house's three rules for targets.

get_directory_property(parent PARENT_DIRECTORY)
if(parent)
  set(MM_WHOLE OFF)
else()
  set(MM_WHOLE ON)
endif()
option(MM_STRICT "Warnings are errors, and no test is left out for want of a library; the scripts set it" ${MM_WHOLE})
add_compile_options(-Wall -Wextra)
if(MM_STRICT)
  add_compile_options(-Werror -Wno-error=maybe-uninitialized)
endif()
if(MM_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    message(FATAL_ERROR "MM_FUZZ needs clang, not ${CMAKE_CXX_COMPILER}: -DCMAKE_CXX_COMPILER=clang++-14")
  endif()
  # libFuzzer counts what the library's code does; what a number from a file becomes is looked at as well.
  set(fuzz_checks address,undefined,float-cast-overflow)
  add_compile_options(-Wno-error -Wno-unknown-warning-option -fsanitize=fuzzer-no-link,${fuzz_checks} -fno-sanitize=vptr,function -fno-sanitize-recover=all
                      -fno-omit-frame-pointer -gline-tables-only)
  add_link_options(-fsanitize=${fuzz_checks} -fno-sanitize=vptr,function)
elseif(MM_SANITIZE STREQUAL "thread")
  # GCC's thread sanitizer does not know fences of atomics (-Wtsan); those here are of Eigen and boost.
  add_compile_options(-fsanitize=thread -fno-omit-frame-pointer -Wno-maybe-uninitialized -Wno-error=tsan)
  add_link_options(-fsanitize=thread)
elseif(MM_SANITIZE)
  # GCC 12 warns of its own <regex> here (GCC bug 105562), a page for each use.
  add_compile_options(-fsanitize=address,undefined -fno-omit-frame-pointer -fno-sanitize-recover=undefined
                      -Wno-maybe-uninitialized)
  add_link_options(-fsanitize=address,undefined)
endif()

# Several sources are compiled together: most of a source's time goes to the headers of Eigen and the standard library.
# A source alone is compiled sooner after a change of it; -DMM_TOGETHER=OFF is for that, and shows a missing #include.
option(MM_TOGETHER "Compile the sources of a folder in groups" ON)
set(CMAKE_UNITY_BUILD ${MM_TOGETHER})
set(CMAKE_UNITY_BUILD_BATCH_SIZE 24)

# mm_library(<folder> [EDGE] [DEPENDS <folders or targets>]): a static library of every .cpp of src/<folder>.
# EDGE: text, files and wires, where the compiler's second level of optimisation buys nothing but its time.
# Only ros_bridge, nodes and tools may ask for `catkin`.
function(mm_library name)
  cmake_parse_arguments(ARG "EDGE" "" "DEPENDS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "_main\\.cpp$")
  add_library(mm_${name} STATIC ${sources})
  set_target_properties(mm_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_include_directories(mm_${name} PUBLIC ${PROJECT_SOURCE_DIR}/src)
  mm_link(mm_${name} PUBLIC ${ARG_DEPENDS})
  if(ARG_EDGE)
    target_compile_options(mm_${name} PRIVATE -O1)
  endif()
endfunction()

# mm_link(<target> <PUBLIC|PRIVATE> <folders or targets>): `catkin` brings ROS and the generated messages.
# The visibility PLAIN is for targets that catkin has linked in the plain signature already (its gtests).
function(mm_link target visibility)
  set(include_visibility ${visibility})
  if(visibility STREQUAL "PLAIN")
    set(include_visibility PRIVATE)
    set(visibility "")
  endif()
  foreach(dependency ${ARGN})
    if(dependency STREQUAL "catkin")
      target_include_directories(${target} SYSTEM ${include_visibility} ${catkin_INCLUDE_DIRS}
                                 ${CATKIN_DEVEL_PREFIX}/${CATKIN_GLOBAL_INCLUDE_DESTINATION})
      target_link_libraries(${target} ${visibility} ${catkin_LIBRARIES})
      add_dependencies(${target} ${PROJECT_NAME}_generate_messages_cpp)
    elseif(TARGET mm_${dependency})
      target_link_libraries(${target} ${visibility} mm_${dependency})
    else()
      target_link_libraries(${target} ${visibility} ${dependency})
    endif()
  endforeach()
endfunction()

# mm_executable(<name> <source> [DEPENDS …]): an installed program of the package.
function(mm_executable name source)
  cmake_parse_arguments(ARG "" "" "DEPENDS" ${ARGN})
  add_executable(${name} ${source})
  mm_link(${name} PRIVATE ${ARG_DEPENDS})
  install(TARGETS ${name} RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
endfunction()
