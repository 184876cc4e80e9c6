#pragma once
#include <optional>
#include <string>

#include "report/certificate.h"
#include "report/dcc_signature.h"

namespace mm {

// Digital calibration certificate: the DCC schema 3.3.0 of PTB (https://ptb.de/dcc) with quantities of the
// D-SI (https://ptb.de/si).

/// The certificate as XML: its figures are those of the page (statedGroups). What ISO/IEC 17025 asks for and
/// nobody stated reads "not stated"; a country that the place does not end with ("Jena, DE") is "ZZ".
/// @param key for which a signature is prepared (its value is still empty); null: not to be signed.
std::string dccOf(const Certificate& certificate, const SigningKey* key = nullptr);

/// ISO 3166-1 code at the end of a place: "Jena, DE" → "DE". @return empty: there is none.
std::string countryOf(const std::string& place);

/// A unit of people ("um/m", "arcsec/deg", "1/K") as the D-SI writes it: "\micro\metre\metre\tothe{-1}".
/// @return empty: the D-SI has no such unit (of a covariate, of a user's formula).
std::optional<std::string> dsiUnit(const std::string& unit);

}  // namespace mm
