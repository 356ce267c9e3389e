#include "rtl/write_buffer.h"

#include <array>
#include <catch2/catch.hpp>
#include <memory>

#include "lockstep/lockstep.h"

namespace metabuffer::test::write_buffer_test {
namespace {

using rtl::MemoryCommand;
using rtl::MemoryData;
using rtl::MemoryWrite;
using rtl::WriteBlock;
using rtl::WriteBuffer;

/// A buffer between a link, whose frames are broken off now and then, and a bus port that writes the full half. Both have
/// the bench's clock. The buffer has no clock gating that could be switched off, so both are alike.
class Buffer final : public Lockstep<WriteBuffer> {
  public:
    Buffer(LockstepBench& bench, const char* name, int block_words, int image_words, int page_words)
        : Lockstep(bench, name,
                   [=](const char* dut, rtl::ClockGating) {
                       MemoryConfig config;
                       config.page_words = page_words;
                       config.words_per_cycle = rtl::kMaximumBeatPixels;
                       config.ports = MemoryPorts::kShared;
                       config.write_block_words = block_words;
                       return std::make_unique<WriteBuffer>(dut, config, image_words);
                   }),
          block_words_(block_words),
          image_words_(image_words),
          page_words_(page_words),
          image_pages_((image_words + page_words - 1) / page_words) {
        for (std::size_t half = 0; half < 2; ++half) {
            halves_[half].full = &out(&WriteBuffer::full_o, half);
            halves_[half].block = &out(&WriteBuffer::block_o, half);
        }
    }

    void stimulate() override {
        Random& random = bench_.random;
        // In a pause a word may stand, and is taken at each clock.
        const bool stands = bench_.pausing() && write_->enable && !random.one_in(20);
        if (!stands) {
            write_ = MemoryWrite{};
            if (bench_.pausing() ? random.one_in(30) : !random.one_in(3)) bring_word();
        }
        ask();
    }
    void expect() override {
        for (Half& half : halves_) {
            *half.full = half.full_due;
            *half.block = half.block_due;
        }
        MemoryData& due = data_due_;
        due.count = 0;
        if (command_->kind == MemoryCommand::Kind::kWrite) {
            due.count = command_->count;
            for (std::size_t i = 0; i < due.count; ++i) {
                const auto index = static_cast<int>(command_->columns[i]) % block_words_;
                due.words[i] = halves_[drain_ ? 1 : 0].words[index];
            }
        }
        data_ = due;
    }
    void edge() override {
        // Lanes without a word stand still.
        if (data_.seen().words != data_due_.words) fail("a lane of data_o is wrong");
        if (!write_->enable) return;
        const auto address = static_cast<int>(write_->address);
        const int index = address % block_words_;
        Half& half = halves_[filling_];
        half.words[index] = write_->data;
        if (index != block_words_ - 1 && address != image_words_ - 1) return;
        half.full_due = !half.full_due;
        const int first = write_->device * image_pages_ * page_words_ + address - index;
        half.block_due = WriteBlock{static_cast<std::uint64_t>(first), static_cast<std::uint32_t>(index + 1),
                                    write_->byte_mask};
        filling_ = 1 - filling_;
        bench_.happened[index == block_words_ - 1 ? "a whole block" : "an image's last words"] += 1;
    }
    void reset() override {
        for (Half& half : halves_) {
            half.full_due = false;
            half.block_due = {};
        }
        filling_ = 0;
    }

  private:
    struct Half {
        Output<bool>* full = nullptr;
        Output<WriteBlock>* block = nullptr;
        bool full_due = false;
        WriteBlock block_due;
        std::array<std::uint64_t, 64> words{};
    };

    /// The next one of the frame, or the first one of another.
    void bring_word() {
        Random& random = bench_.random;
        if (next_ == image_words_ || random.one_in(100)) {
            next_ = 0;
            device_ = random.one_in(2) ? 1 : 0;
            mask_ = random.one_in(2) ? MemoryWrite::kColourBytes : MemoryWrite::kDepthBytes;
        }
        write_ = MemoryWrite{true, device_, static_cast<std::uint32_t>(next_), random.bits(), mask_};
        ++next_;
    }
    /// Words of the half that does not fill, in any order, or another command.
    void ask() {
        Random& random = bench_.random;
        drain_ = filling_ == 0;
        MemoryCommand command;
        const WriteBlock& block = halves_[1 - filling_].block_due;
        if (block.words > 0 && random.one_in(2)) {
            command.kind = random.one_in(4) ? MemoryCommand::Kind::kRead : MemoryCommand::Kind::kWrite;
            command.count = static_cast<std::uint8_t>(random.between(1, rtl::kMaximumBeatPixels));
            for (std::uint32_t& column : command.columns) {
                const auto word =
                    static_cast<std::uint64_t>(random.between(0, static_cast<int>(block.words) - 1));
                column =
                    static_cast<std::uint32_t>((block.address + word) % static_cast<unsigned>(page_words_));
            }
        }
        command_ = command;
    }

    int block_words_, image_words_, page_words_, image_pages_;
    Input<MemoryWrite>& write_ = in(&WriteBuffer::write_i);
    Input<MemoryCommand>& command_ = in(&WriteBuffer::command_i);
    Input<bool>& drain_ = in(&WriteBuffer::drain_i);
    Output<MemoryData>& data_ = out(&WriteBuffer::data_o);
    int next_ = 0;  ///< word of the frame on the link
    std::uint8_t device_ = 0, mask_ = MemoryWrite::kColourBytes;
    std::array<Half, 2> halves_;
    std::size_t filling_ = 0;
    MemoryData data_due_;
};

TEST_CASE("write buffer: in lockstep with its reference") {
    LockstepBench bench(2215);
    const Buffer usual(bench, "usual", 4, 10, 8);
    const Buffer whole_image(bench, "whole_image", 16, 16, 16);
    const Buffer less_than_a_block(bench, "less_than_a_block", 64, 5, 128);
    const Buffer single_words(bench, "single_words", 1, 3, 2);
    bench.run(20'000,
              {{"a whole block", 500}, {"an image's last words", 500}, {LockstepBench::kAsleep, 500}});
}

}  // namespace
}  // namespace metabuffer::test::write_buffer_test
