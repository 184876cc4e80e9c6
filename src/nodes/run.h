#pragma once

namespace mm {

// The nodes: each until ROS or a signal ends it. @return the exit status of its program.
int runAxisDriver(int argc, char** argv);
int runCalibrationServer(int argc, char** argv);
int runCompensation(int argc, char** argv);
int runMeasure(int argc, char** argv);
int runProbe(int argc, char** argv);
int runTemperature(int argc, char** argv);
int runWorkbench(int argc, char** argv);

}  // namespace mm
