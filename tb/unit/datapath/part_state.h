#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace metabuffer::test {

/// What a part of a block without a clock shows of its registers in a waveform: their values by name.
class PartState {
  public:
    template <typename Part>
    explicit PartState(const Part& part) {
        part.visit_state(*this);
    }
    template <typename Number>
    void operator()(const char* name, const Number& value, std::int64_t /*largest*/,
                    std::int64_t /*smallest*/ = 0) const {
        values_[name] = static_cast<std::int64_t>(value);
    }
    std::int64_t operator[](const std::string& name) const { return values_.at(name); }

  private:
    mutable std::map<std::string, std::int64_t> values_;  // a part takes its visitor as a constant
};

}  // namespace metabuffer::test
