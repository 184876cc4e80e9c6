#pragma once
#include "export/export_target.h"

namespace mm {

// What each controller has a place for, from its public documents (docs/export.md).

/// COMP_FILE triplets of each joint (position; trim upwards; trim downwards) and the lines of the INI file.
/// LinuxCNC: INI configuration, [JOINT_n] COMP_FILE, COMP_FILE_TYPE, BACKLASH.
Exported toLinuxcnc(const NeededCorrection& needed, const ExportOptions& options);
/// SET_SKEW, a bed mesh and z_thermal_adjust. Klipper: Skew_Correction, Bed_Mesh, Config_Reference and the
/// sources of these modules.
Exported toKlipper(const NeededCorrection& needed, const ExportOptions& options);
/// M425 and M852. Marlin: M425, M852, planner.h (skew), backlash.cpp.
Exported toMarlin(const NeededCorrection& needed, const ExportOptions& options);
/// M556 and M425. RepRapFirmware: G-code dictionary, Move::AxisTransform.
Exported toReprapfirmware(const NeededCorrection& needed, const ExportOptions& options);
/// $160 and following: backlash. grblHAL: settings.h, motion_control.c.
Exported toGrblhal(const NeededCorrection& needed, const ExportOptions& options);
/// Tables $AN_CEC of the interpolatory compensation: each axis by each axis. SINUMERIK Function Manual
/// Extended Functions, K3.
Exported toSiemens(const NeededCorrection& needed, const ExportOptions& options);
/// Compensation value tables (.COM) and their assignment (.CMA). Technical Manual, nonlinear axis error
/// compensation.
Exported toHeidenhain(const NeededCorrection& needed, const ExportOptions& options);
/// Stored pitch error compensation, parameters 3620 to 3624, and backlash, 1851. Fanuc parameter manual.
Exported toFanuc(const NeededCorrection& needed, const ExportOptions& options);
/// Compensation value lists: leadscrew (bilateral), cross and plane compensation. TF5200 Axis compensation.
Exported toBeckhoff(const NeededCorrection& needed, const ExportOptions& options);
/// An ISG_CSV table of volumetric compensation with its configuration. TF5280; ISG kernel, FCT-C26.
Exported toIsg(const NeededCorrection& needed, const ExportOptions& options);
/// The eighteen component errors of three linear axes as tables, with the kinematic chain. ISO 230-1, 3.4.
Exported toCsv(const NeededCorrection& needed, const ExportOptions& options);

}  // namespace mm
