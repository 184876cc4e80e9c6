#pragma once
#include <string>

#include "calibration_file/calibration.h"
#include "machine/machine.h"

namespace mm {

/// Why a calibration may not be applied on a machine: what its URDF has and this one's has not, another
/// serial, another namespace. Two machines that state the same serial are one, whatever their namespaces;
/// without serials the namespace tells machines of one URDF apart.
/// @param space namespace of the nodes ("/", "/m1"); empty: not known. @return one sentence; empty: it fits.
std::string misfitOf(const Calibration& calibration, const Machine& machine, const std::string& space);

/// The same between the machine of a calibration and that of a session, or of another calibration.
/// @param space namespace where `other` measured; empty: not known. @param there what the other is called:
/// "in the session". @return what differs, in words.
std::string differenceOf(const Calibration& calibration, const Machine& other, const std::string& space,
                         const std::string& there);

/// What of that could not be found out, as the file does not tell it; empty: all was.
std::string uncheckedFit(const Calibration& calibration, const Machine& machine);

/// Part of the default folder of calibrations for one machine: its serial, else its namespace; empty: the
/// only machine there is.
std::string folderOf(const Machine& machine, const std::string& space);

}  // namespace mm
