#include "fifo_coverage.h"

#include "datapath/composer_buffer.h"

namespace metabuffer::coverage {

FifoCoverage::FifoCoverage(const FifoGoals& goals, const Scenario& scenario)
    : goals_(goals),
      capacity_(static_cast<std::uint32_t>(scenario.composer.buffer_pixels)),
      addresses_(static_cast<std::uint32_t>(buffer_addresses(scenario.composer.buffer_pixels))),
      free_(capacity_) {}

void FifoCoverage::clock(rtl::FifoWires& wires) {
    const rtl::FifoWrite& write = wires.write.read();
    const rtl::FifoRead& read = wires.read.read();
    const rtl::FifoRelease& release = wires.release.read();
    const std::uint32_t free = wires.free.read();
    goals_.write.hit_if(write.count > 0);
    goals_.write_wraps.hit_if(write.count > 0 && write.address + write.count > addresses_);
    if (read.enable) {
        goals_.read.hit();
        goals_.read_of_written.hit_if((read.address + addresses_ - write.address) % addresses_ < write.count);
        const std::uint32_t back = (last_read_ + addresses_ - read.address) % addresses_;
        goals_.read_again.hit_if(has_read_ && back > 0 && back < addresses_ / 2);
        goals_.both.hit_if(write.count > 0 && release.any());
        last_read_ = read.address;
        has_read_ = true;
    }
    goals_.release_one.hit_if(release.oldest == 1);
    goals_.release_several.hit_if(release.oldest > 1);
    goals_.release_abandoned.hit_if(release.newest > 0);
    goals_.full.hit_if(free == 0 && free_ > 0);
    goals_.drained.hit_if(free == capacity_ && free_ < capacity_);
    if (wires.second_row != nullptr) {
        goals_.second_read.hit_if(read.enable && wires.second_row->read.read().enable);
    }
    free_ = free;
}

}  // namespace metabuffer::coverage
