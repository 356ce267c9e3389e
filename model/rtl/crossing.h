#pragma once

#include <string>

#include "rtl/register.h"

namespace metabuffer::rtl {

/// A level that crosses from another clock domain: two registers in the receiver's domain, so a change is seen at the
/// second receiver edge after it at the earliest. One bit only; what goes with it must not change.
class Synchronizer {
  public:
    Synchronizer(RegisterSet& set, const std::string& name)
        : captured_(set, name + "_captured"), stable_(set, name + "_stable") {}

    /// The value as the receiver's logic sees it at this edge, given the input now. Call it once at each edge.
    bool sample(bool input) {
        stable_ = captured_;
        captured_ = input;
        return stable_;
    }

  private:
    Register<bool> captured_;
    Register<bool> stable_;
};

/// Events that cross from another clock domain, as changes of a level. The sender keeps what goes with an event until the
/// receiver has answered it.
class Crossing {
  public:
    Crossing(RegisterSet& set, const std::string& name) : level_(set, name), seen_(set, name + "_seen") {}

    /// True at the edge at which an event arrives, given the level now. Call it once at each edge.
    bool arrives(bool input) {
        const bool level = level_.sample(input);
        if (level == seen_) return false;
        seen_ = level;
        return true;
    }

  private:
    Synchronizer level_;
    Register<bool> seen_;
};

}  // namespace metabuffer::rtl
