set(effects_test_dependencies Threads::Threads)
