#pragma once
#include <string>

namespace mm {

/// How a benchmark's sessions differ from the plan as it is written.
struct SessionVariant {
  bool oneSided = false;         // every contact from one side of x, of y and of z
  bool freeCentres = false;      // the balls' centres are estimated, the artifact lies where it says
  bool outliers = false;         // 3 % of the contacts, 20 um
  bool heavyTails = false;       // Student's t with three degrees of freedom, of the same standard deviation
  bool timeTemperature = false;  // the room only warms up: temperatures go with time
  int contacts = 0;              // as near as the number of balls allows; 0: as in the plan
  std::string statedNoise;  // factor on what the artifact states; "none": not stated; empty: as in the plan

  /// As the plan is written.
  bool none() const {
    return !oneSided && !freeCentres && !outliers && !heavyTails && !timeTemperature && contacts == 0 &&
           statedNoise.empty();
  }
};

/// The plan's YAML, changed. @throw InputError naming `source` where the plan is not of touches on balls.
std::string varied(const std::string& planYaml, const std::string& source, const SessionVariant& variant);
/// The same without random errors of the readings, and not rough.
std::string withoutNoise(const std::string& planYaml);

}  // namespace mm
