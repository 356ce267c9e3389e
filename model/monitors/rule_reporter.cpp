#include "monitors/rule_reporter.h"

namespace metabuffer::monitors {

void RuleReporter::report(const char* group, const char* rule, const std::string& signal, std::int64_t cycle,
                          std::int64_t frame, const std::string& detail) {
    const auto [entry, first] = last_frame_.try_emplace(group + (' ' + signal), frame);
    if (!first && entry->second == frame) {
        ++unreported_;
        return;
    }
    entry->second = frame;
    log_.add({rule, signal, clock_, cycle, frame, detail});
}

std::string bound_signal(const sc_core::sc_port_base& port, const sc_core::sc_interface* bound) {
    const auto* object = dynamic_cast<const sc_core::sc_object*>(bound);
    return object != nullptr ? object->basename() : port.basename();
}

}  // namespace metabuffer::monitors
