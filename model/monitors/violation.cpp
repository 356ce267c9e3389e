#include "monitors/violation.h"

#include <systemc>

namespace metabuffer::monitors {

std::string to_string(const Violation& violation) {
    return violation.rule + ": " + violation.signal + ", " + violation.clock + " clock " +
           std::to_string(violation.cycle) +
           (violation.frame < 0 ? std::string() : ", frame " + std::to_string(violation.frame)) + ": " +
           violation.detail;
}

void ViolationLog::add(const Violation& violation) {
    ++count_;
    if (listener_) {
        listener_(violation);
        return;
    }
    SC_REPORT_ERROR(("/metabuffer/monitor/" + violation.rule).c_str(), to_string(violation).c_str());
}

}  // namespace metabuffer::monitors
