#pragma once

#include <map>
#include <string>

#include "cover_group.h"
#include "scenario/scenario.h"

namespace metabuffer::coverage {

/// Goals that the table of scenario keys gives: each value of a key that has few, and pairs of values of two keys.
class KeyGoals {
  public:
    explicit KeyGoals(Coverage& coverage);

    void cover(const Scenario& scenario) const;
    void cover(const Fault& fault) const;

  private:
    void hit_if_goal(const std::string& name) const;

    std::map<std::string, Bin> bins_;
};

}  // namespace metabuffer::coverage
