#pragma once
#include <string>

#include "effects/effect.h"

namespace mm {

/// Whose an effect is, where it is not the machine's in all sessions: keys that any effect may have beside
/// its own. `from_session: N`: it acts from the N-th of several sessions on, counted from 1; `stylus: NAME`:
/// with that stylus alone.
struct Owner {
  int fromSession = 1;
  std::string stylus;  // empty: any

  bool isMachine() const {
    return fromSession == 1 && stylus.empty();
  }  ///< in all sessions, with every stylus
};

/// Takes the owner's keys out of a spec. @throw InputError: a number of a session that is none.
Owner takeOwner(EffectSpec& spec);
/// The spec with the owner's keys behind its own.
EffectSpec withOwner(EffectSpec spec, const Owner& owner);

/// The same law, where its owner acts. @throw InputError: the domain has no such session or stylus.
EffectPtr ownedEffect(EffectPtr law, const Owner& owner, const Domain& domain);

}  // namespace mm
