#include <pluginlib/class_list_macros.hpp>

#include "drivers/simulated_controller.h"

PLUGINLIB_EXPORT_CLASS(mm::SimulatedController, mm::AxisController)
