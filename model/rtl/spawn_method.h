#pragma once

#include <sysc/kernel/sc_spawn.h>

#include <systemc>
#include <vector>

namespace metabuffer::rtl {

/// A method process that is called by these events, and not at the start: for what is known only after elaboration.
template <typename Method>
void spawn_method(const Method& method, const std::vector<const sc_core::sc_event*>& events) {
    sc_core::sc_spawn_options options;
    options.spawn_method();
    options.dont_initialize();
    for (const sc_core::sc_event* const event : events) options.set_sensitivity(event);
    sc_core::sc_spawn(method, sc_core::sc_gen_unique_name("method"), &options);
}

}  // namespace metabuffer::rtl
