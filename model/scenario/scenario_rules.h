#pragma once

#include <optional>
#include <string>

#include "scenario/scenario.h"

namespace metabuffer {

/// A rule that a scenario breaks: the key path, and what is wrong and what would be right.
struct RuleViolation {
    std::string path;
    std::string message;
};

/// What is wrong with a range of depths whose ends are the same.
std::string same_depths(double depth);

/// The first rule that a scenario breaks, apart from those about its images.
std::optional<RuleViolation> settings_violation(const Scenario& scenario);

/// The first rule that its images, tables and viewports break.
std::optional<RuleViolation> renderers_violation(const Scenario& scenario);

}  // namespace metabuffer
