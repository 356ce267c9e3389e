#include "rtl/composer_fifo.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "expected_report.h"
#include "lockstep/lockstep.h"
#include "lockstep/waveform_case.h"
#include "support/random_seed.h"

namespace metabuffer::test::composer_fifo_test {
namespace {

using rtl::ComposerFifo;
using rtl::FifoRead;
using rtl::FifoRelease;
using rtl::FifoWrite;

/// The FIFO has no clock gating of its own, so both are alike.
Lockstep<ComposerFifo>::Factory fifo_of(int capacity, int rows = 1) {
    return [=](const char* name, rtl::ClockGating) {
        return std::make_unique<ComposerFifo>(name, capacity, rows);
    };
}

/// The FIFO as a map of words and a count.
class Fifo final : public Lockstep<ComposerFifo> {
  public:
    Fifo(LockstepBench& bench, const char* name, int capacity, int addresses, int rows = 1)
        : Lockstep(bench, name, fifo_of(capacity, rows)), capacity_(capacity), addresses_(addresses) {
        ReadPort& first =
            ports_.emplace_back(ReadPort{in(&ComposerFifo::read_i), {{out(&ComposerFifo::word_o)}}});
        if (rows == 1) return;
        first.words.push_back(
            {out_part<std::uint64_t>([](auto& dut) -> auto& { return dut.second_row->next_word_o; })});
        ports_.push_back(
            {in_part<FifoRead>([](auto& dut) -> auto& { return dut.second_row->row_read_i; }),
             {{out_part<std::uint64_t>([](auto& dut) -> auto& { return dut.second_row->row_word_o; })},
              {out_part<std::uint64_t>(
                  [](auto& dut) -> auto& { return dut.second_row->row_next_word_o; })}}});
    }

    /// In a pause now and then one input comes alone.
    void stimulate() override {
        Random& random = bench_.random;
        const int alone = random.between(0, 60);
        const auto comes = [&](int input) { return bench_.pausing() ? alone == input : random.one_in(2); };
        const int oldest = comes(0) ? some_of(held_) : 0;
        const int most = std::min(rtl::kMaximumBeatPixels, capacity_ - held_ + oldest);
        FifoWrite write;
        write.count = static_cast<std::uint8_t>(comes(1) ? random.between(0, most) : 0);
        // The address of no words has no meaning.
        const int address = write.count > 0 ? next_ : random.between(0, 2 * addresses_);
        write.address = static_cast<std::uint32_t>(address);
        for (std::uint64_t& word : write.words) word = random.bits();
        write_ = write;
        const int newest = alone == 2 ? some_of(held_ - oldest + write.count) : 0;
        release_ = FifoRelease{static_cast<std::uint32_t>(oldest), static_cast<std::uint32_t>(newest)};
        for (std::size_t port = 0; port < ports_.size(); ++port) {
            ports_[port].read = FifoRead{};
            if (!comes(3 + static_cast<int>(port)) || memory_.empty()) continue;
            const bool of_beat = write.count > 0 && random.one_in(2);
            const auto stored =
                std::next(memory_.begin(), random.between(0, static_cast<int>(memory_.size()) - 1));
            const int word =
                of_beat ? (next_ + random.between(0, write.count - 1)) % addresses_ : stored->first;
            ports_[port].read = FifoRead{true, static_cast<std::uint32_t>(word)};
        }
    }
    void expect() override {
        free_ = static_cast<std::uint32_t>(capacity_ - held_);
        for (ReadPort& port : ports_) {
            for (ReadWord& word : port.words) {
                word.output.ignore();
                if (word.due) word.output = *word.due;
            }
        }
    }
    void edge() override {
        for (std::size_t i = 0; i < write_->count; ++i) {
            memory_[next_] = write_->words[i];
            next_ = (next_ + 1) % addresses_;
        }
        for (ReadPort& port : ports_) {
            if (!port.read->enable) continue;
            int address = static_cast<int>(port.read->address);
            for (ReadWord& word : port.words) {
                const auto stored = memory_.find(address);
                word.due = stored == memory_.end() ? std::nullopt : std::optional(stored->second);
                address = (address + 1) % addresses_;
            }
        }
        held_ += write_->count - static_cast<int>(release_->oldest + release_->newest);
        bench_.happened["it was full"] += held_ == capacity_ ? 1 : 0;
        bench_.happened["a pixel was released at the edge that brought it"] +=
            held_ == 0 && write_->count > 0 ? 1 : 0;
    }
    /// What is stored stays, but nobody says what becomes of the words of a beat that comes now.
    void reset() override {
        for (int i = 0; i < write_->count; ++i) memory_.erase((next_ + i) % addresses_);
        held_ = 0;
        for (ReadPort& port : ports_) {
            for (ReadWord& word : port.words) word.due = 0;
        }
    }

  private:
    struct ReadWord {
        Output<std::uint64_t>& output;
        std::optional<std::uint64_t> due = 0;  ///< none: the word at its address is not known
    };
    struct ReadPort {
        Input<FifoRead>& read;
        std::vector<ReadWord> words;  ///< at the address, and after it
    };

    int some_of(int pixels) const {
        Random& random = bench_.random;
        return random.one_in(8) ? pixels : random.between(0, std::min(pixels, rtl::kMaximumBeatPixels));
    }

    int capacity_, addresses_;
    Input<FifoWrite>& write_ = in(&ComposerFifo::write_i);
    Input<FifoRelease>& release_ = in(&ComposerFifo::release_i);
    Output<std::uint32_t>& free_ = out(&ComposerFifo::free_o);
    std::map<int, std::uint64_t> memory_;  ///< words by address
    int next_ = 0;                         ///< address of the next beat
    int held_ = 0;
    std::vector<ReadPort> ports_;
};

TEST_CASE("composer fifo: in lockstep with its reference") {
    LockstepBench bench(913);
    const Fifo smallest(bench, "smallest", 4, 16);
    const Fifo middle(bench, "middle", 45, 64);
    const Fifo whole_memory(bench, "whole_memory", 32, 32);
#ifndef METABUFFER_REPLICATES_ONLY
    const Fifo two_rows(bench, "two_rows", 20, 32, 2);
#endif
    bench.run(30'000, {{"it was full", 500}, {"a pixel was released at the edge that brought it", 30}});
}

FifoWrite beat(int address, int count) {
    FifoWrite write;
    write.address = static_cast<std::uint32_t>(address);
    write.count = static_cast<std::uint8_t>(count);
    return write;
}

TEST_CASE("composer fifo: what it cannot do is reported at its edge") {
    // Of a FIFO of 10 pixels, in 16 addresses, that holds 8.
    struct Wrong {
        const char* id;
        FifoWrite write;
        FifoRead read;
        FifoRelease release;
    };
    const std::vector<Wrong> wrongs{{"full", beat(8, 3), {}, {}},
                                    {"empty", {}, {}, {8, 1}},
                                    {"address", {}, {true, 16}, {}},
                                    {"address", beat(16, 1), {}, {}}};
    std::map<std::string, ExpectedReport> reports;
    LockstepBench bench;
    std::vector<std::unique_ptr<WaveformCase<ComposerFifo>>> fifos;
    for (const Wrong& wrong : wrongs) {
        reports.try_emplace(wrong.id, std::string("/metabuffer/composer_fifo/") + wrong.id);
        const std::string wait(fifos.size(), '.');
        fifos.push_back(std::make_unique<WaveformCase<ComposerFifo>>(
            bench, "fifo_" + std::to_string(fifos.size()), fifo_of(10)));
        WaveformCase<ComposerFifo>& fifo = *fifos.back();
        fifo.drive("8" + wait + "x.", &ComposerFifo::write_i, {{'8', beat(0, 8)}, {'x', wrong.write}});
        fifo.drive("." + wait + "x.", &ComposerFifo::read_i, {{'x', wrong.read}});
        fifo.drive("." + wait + "x.", &ComposerFifo::release_i, {{'x', wrong.release}});
        const std::string any(wait.size() + 3, '?');
        fifo.check(any, &ComposerFifo::word_o);
        fifo.check(any, &ComposerFifo::free_o);
    }
    for (std::size_t i = 0; i < wrongs.size(); ++i) {
        const auto total = [&reports] {
            int count = 0;
            for (const auto& [id, report] : reports) count += report.count();
            return count;
        };
        INFO(i);
        const ExpectedReport& report = reports.at(wrongs[i].id);
        const int clock = static_cast<int>(i) + 1;
        bench.run(clock);
        const int before = report.count();
        CHECK(total() == 2 * static_cast<int>(i));  // there are two of each
        bench.run(clock + 1);
        CHECK(report.count() == before + 2);
    }
}

TEST_CASE("composer fifo: what it cannot do is reported at each edge at which it stands") {
    constexpr int kStands = 3 * rtl::Clocked::kIdleEdges;
    const ExpectedReport full("/metabuffer/composer_fifo/full");
    const ExpectedReport address("/metabuffer/composer_fifo/address");
    LockstepBench bench;
    WaveformCase<ComposerFifo> fifo(bench, "fifo", fifo_of(10));
    const std::string stands(kStands, 'x'), none(kStands, '.'), any(2 * kStands + 1, '?');
    FifoRead beyond;
    beyond.enable = true;
    beyond.address = 16;
    fifo.drive("8" + stands + none, &ComposerFifo::write_i, {{'8', beat(0, 8)}, {'x', beat(8, 3)}});
    fifo.drive("." + none + stands, &ComposerFifo::read_i, {{'x', beyond}});
    fifo.drive("." + none + none, &ComposerFifo::release_i);
    fifo.check(any, &ComposerFifo::word_o);
    fifo.check(any, &ComposerFifo::free_o);
    fifo.run();
    // There are two.
    CHECK(full.count() == 2 * kStands);
    CHECK(address.count() == 2 * kStands);
}

}  // namespace
}  // namespace metabuffer::test::composer_fifo_test
