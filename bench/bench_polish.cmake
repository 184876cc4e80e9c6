find_package(Ceres REQUIRED)
set(bench_polish_dependencies estimation model Ceres::ceres)
target_include_directories(bench_polish PRIVATE ${PROJECT_SOURCE_DIR}/test/support)
