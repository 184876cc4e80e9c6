set(effects_test_dependencies yaml-cpp Threads::Threads)
