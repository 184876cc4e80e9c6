#include <pluginlib/class_list_macros.hpp>

#include "drivers/linuxcnc_controller.h"

PLUGINLIB_EXPORT_CLASS(mm::LinuxCncController, mm::AxisController)
