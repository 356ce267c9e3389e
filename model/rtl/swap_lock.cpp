#include "rtl/swap_lock.h"

#include <algorithm>

namespace metabuffer::rtl {
namespace {

bool high(const In<bool>& wire) { return wire.read(); }

}  // namespace

SwapLock::SwapLock(const sc_core::sc_module_name& name, int displays)
    : Block(name),
      framedone_i("framedone_i", static_cast<std::size_t>(displays)),
      framebad_i("framebad_i", static_cast<std::size_t>(displays)) {
    SC_METHOD(update);
    for (auto& wire : framedone_i) {
        sensitive << wire;
    }
    for (auto& wire : framebad_i) {
        sensitive << wire;
    }
}

void SwapLock::update() {
    swaplock_o.write(std::all_of(framedone_i.begin(), framedone_i.end(), high));
    swapskip_o.write(std::any_of(framebad_i.begin(), framebad_i.end(), high));
}

void SwapLock::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, swaplock_o.port(), path("SWAPLOCK"));
    sc_core::sc_trace(file, swapskip_o.port(), path("SWAPSKIP"));
}

ColumnStall::ColumnStall(const sc_core::sc_module_name& name, int renderers)
    : Block(name), stall_i("stall_i", static_cast<std::size_t>(renderers)) {
    SC_METHOD(update);
    for (auto& wire : stall_i) {
        sensitive << wire;
    }
}

void ColumnStall::update() { column_stall_o.write(std::any_of(stall_i.begin(), stall_i.end(), high)); }

void ColumnStall::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, column_stall_o.port(), path("COLUMNSTALL"));
}

}  // namespace metabuffer::rtl
