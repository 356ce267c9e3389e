#pragma once

#include <string>
#include <systemc>
#include <utility>

namespace metabuffer::test {

/// A report that the test provokes: it is counted, and the simulation goes on. Every other warning or error
/// of the model fails the test.
class ExpectedReport {
  public:
    explicit ExpectedReport(std::string id) : id_(std::move(id)), count_before_(total()) {
        sc_core::sc_report_handler::set_actions(id_.c_str(), sc_core::SC_DO_NOTHING);
    }
    ExpectedReport(const ExpectedReport&) = delete;
    ExpectedReport& operator=(const ExpectedReport&) = delete;
    ~ExpectedReport() { sc_core::sc_report_handler::set_actions(id_.c_str(), sc_core::SC_THROW); }

    /// How often it has been raised.
    int count() const { return total() - count_before_; }

  private:
    int total() const { return sc_core::sc_report_handler::get_count(id_.c_str()); }

    std::string id_;
    int count_before_;
};

}  // namespace metabuffer::test
