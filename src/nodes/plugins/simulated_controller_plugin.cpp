#include <pluginlib/class_list_macros.hpp>

#include "simulated_controller/simulated_controller.h"

PLUGINLIB_EXPORT_CLASS(mm::SimulatedController, mm::AxisController)
