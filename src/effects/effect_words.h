#pragma once
#include <map>
#include <string>
#include <vector>

#include "effects/effect_spec.h"

namespace mm {

/// An effect as it is called in a workshop: "backlash of x", "straightness of x in z, degree 2". A type that
/// has no phrase (a plugin's) is told by its own name and keys.
std::string inWords(const EffectSpec& effect);

/// A name in words: "time_constant" is "time constant".
std::string spaced(std::string name);

/// Several effects, as a list: "a, b and c"; of more than `shown`, the first and how many more.
std::string listInWords(const std::vector<EffectSpec>& effects, std::size_t shown = 4);

/// The types of words.yaml, in its order, which is that of the catalogue.
std::vector<std::string> typesInWords();

/// What a parameter of an effect is: "radius of the ball minus that of the artifact file";
/// empty: words.yaml does not say, as of a plugin's.
std::string meaningOf(const EffectSpec& effect, const std::string& parameter);

/// What words.yaml says of an effect. @param what "cause", "remedy" or "shown_by".
/// @param variant of its words, where its law chose one. @param more words that its law gives, by name.
std::string wordsOf(const EffectSpec& effect, const std::string& what, const std::string& variant,
                    const std::map<std::string, std::string>& more);

}  // namespace mm
