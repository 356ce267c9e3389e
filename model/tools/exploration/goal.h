#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/exploration/expression.h"
#include "tools/exploration/results_database.h"
#include "tools/exploration/value.h"

namespace metabuffer::exploration {

/// The values of an expression's names in a run, which must outlive the function: figures first, then settings.
std::function<Value(const std::string& name)> values_in(const RunRecord& run);

/// What a search asks of a run.
class Goal {
  public:
    /// As the constructor of Expression. Throws InputError.
    Goal(const std::string& text, const std::vector<std::string>& names, const std::string& where);

    const Expression& expression() const { return whole_; }
    bool is_met_by(const RunRecord& run) const;
    /// Why a run does not meet it: the run's own reason, or the figures of those parts that do not hold.
    std::string missed_by(const RunRecord& run) const;

  private:
    Expression whole_;
    std::vector<Expression> parts_;  ///< which it asks for together
};

}  // namespace metabuffer::exploration
