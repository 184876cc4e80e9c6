set(simulation_test_dependencies Eigen3::Eigen ros_bridge catkin estimation model effects)
