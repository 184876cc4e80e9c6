// Digital certificates: what is read names a key, or has no signature.
#include "fuzz_support.h"
#include "report/dcc_signature.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  mm::DccContents found;
  const auto read = [&] { found = mm::dccContents(mm::fuzz::textOf(data, size), "certificate.xml"); };
  if (!mm::fuzz::takes(read)) return 0;
  if (found.signature.there != (found.signature.fingerprint.size() == 64)) std::abort();
  return 0;
}
