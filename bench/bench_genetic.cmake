# Against pagmo's simple genetic algorithm: left out where pagmo is not installed.
find_package(Pagmo QUIET)
set(bench_genetic_dependencies estimation)
target_include_directories(bench_genetic PRIVATE ${PROJECT_SOURCE_DIR}/test/support)
if(Pagmo_FOUND)
  list(APPEND bench_genetic_dependencies Pagmo::pagmo)
  # Lets the compiler vectorise the peer's fitness, sums and roots included.
  target_compile_options(bench_genetic PRIVATE -O3 -ffast-math)
else()
  message(STATUS "bench_genetic is left out: pagmo not found")
  set_target_properties(bench_genetic PROPERTIES EXCLUDE_FROM_ALL ON)
endif()
