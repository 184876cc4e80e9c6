// Calibration files. The checksum is put right first, else no damage would come past it; what is read is then
// written and read to the same bits.
#include "base/checksum.h"
#include "calibration_file/calibration_yaml.h"
#include "fuzz_support.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string text = mm::fuzz::textOf(data, size);
  mm::fuzz::takes([&] { mm::parseCalibration(text, "c.yaml"); });
  const std::size_t first = text.rfind("checksum:", 0) == 0 ? text.find('\n') : std::string::npos;
  const std::string body = first == std::string::npos ? text : text.substr(first + 1);
  text = "checksum: crc64-" + mm::checksumOf(body) + "\n" + body;
  mm::Calibration calibration;
  if (!mm::fuzz::takes([&] { calibration = mm::parseCalibration(text, "c.yaml"); })) return 0;
  std::string written;
  if (!mm::fuzz::takes([&] { written = mm::calibrationYaml(calibration); })) return 0;
  mm::fuzz::mustTake(
      [&] {
        if (mm::calibrationYaml(mm::parseCalibration(written, "w.yaml")) != written)
          mm::fuzz::broken("a calibration that was written is read to the bit");
      },
      "a calibration that was written is read");
  return 0;
}
