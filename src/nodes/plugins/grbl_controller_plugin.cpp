#include <pluginlib/class_list_macros.hpp>

#include "drivers/grbl_controller.h"

PLUGINLIB_EXPORT_CLASS(mm::GrblController, mm::AxisController)
