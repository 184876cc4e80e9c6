set(bench_thermal_dependencies thermal)
target_include_directories(bench_thermal PRIVATE ${PROJECT_SOURCE_DIR}/test/support)
