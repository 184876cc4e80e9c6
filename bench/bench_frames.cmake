set(bench_frames_dependencies nodes catkin)
