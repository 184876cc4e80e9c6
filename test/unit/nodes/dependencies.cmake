set(nodes_test_dependencies catkin)
