#include "tools/program/level_process.h"

#include <cstdint>
#include <cstring>

#include "report/report.h"
#include "rtl/run.h"
#include "tlm/run.h"

namespace metabuffer {

/// The header of each message. Both ends are the same program, so they agree on its layout.
struct LevelMessage {
    enum class Kind : std::uint8_t { kPicture, kProgress, kReport, kFailure };
    Kind kind = Kind::kPicture;
    std::int32_t frame = 0;  ///< of a picture, as the next three
    std::int32_t display = 0;
    std::int32_t width_pixels = 0;
    std::int32_t height_pixels = 0;
    std::int32_t status = 0;  ///< of a failure: its ExitStatus; of a report: whether the watchdog tripped
    double number = 0.0;      ///< of progress: the share; of a report: simulation seconds
    std::int64_t core_cycles = 0;  ///< of a report
    std::uint64_t bytes = 0;       ///< of the payload, which follows
};

namespace {

/// A run's messages to the parent.
class Sender {
  public:
    explicit Sender(const ChildProcess::Sender& pipe) : pipe_(pipe) {}

    void send(LevelMessage message, const void* payload, std::size_t bytes) const {
        message.bytes = bytes;
        pipe_.send(&message, sizeof message);
        pipe_.send(payload, bytes);
    }
    void send_picture(int frame, int display, const ColourImage& image) const {
        LevelMessage message;
        message.frame = frame;
        message.display = display;
        message.width_pixels = image.width_pixels;
        message.height_pixels = image.height_pixels;
        send(message, image.values.data(), image.values.size() * sizeof image.values[0]);
    }
    void send_progress(double share) const {
        LevelMessage message;
        message.kind = LevelMessage::Kind::kProgress;
        message.number = share;
        send(message, nullptr, 0);
    }
    void send_report(const RunReport& report, double simulation_seconds) const {
        LevelMessage message;
        message.kind = LevelMessage::Kind::kReport;
        message.status = report.watchdog.empty() ? 0 : 1;
        message.number = simulation_seconds;
        message.core_cycles = report.core_cycles;
        const std::string text = report_json(report);
        send(message, text.data(), text.size());
    }
    void send_failure(const Failure& failure) const {
        LevelMessage message;
        message.kind = LevelMessage::Kind::kFailure;
        message.status = failure.status;
        send(message, failure.message.data(), failure.message.size());
    }

  private:
    ChildProcess::Sender pipe_;
};

/// Runs a level with its own options; `run` is the level's function.
template <typename Options, typename Run>
void run_level(const Scenario& scenario, Options options, bool images, const Sender& sender, Run run) {
    if (images) {
        options.on_frame_shown = [&sender](const DisplayedFrame& displayed) {
            sender.send_picture(displayed.frame, displayed.display, displayed.picture);
        };
    }
    options.on_progress = [&sender](std::int64_t /*core_cycles*/, double share) {
        sender.send_progress(share);
    };
    const auto result = run(scenario, options);
    sender.send_report(result.report, result.simulation_seconds);
}

/// The work of a run's process.
void run_and_send(TimedLevel level, const Scenario& scenario, bool images, const Sender& sender) {
    try {
        if (level == TimedLevel::kRtl) {
            run_level(scenario, rtl::RunOptions{}, images, sender, rtl::run);
        } else {
            tlm::RunOptions options;
            options.images = images;
            run_level(scenario, options, images, sender, tlm::run);
        }
    } catch (...) {
        sender.send_failure(current_failure());
    }
}

}  // namespace

LevelProcess::LevelProcess(TimedLevel level, const Scenario& scenario, bool images)
    : level_(level), process_([level, &scenario, images](const ChildProcess::Sender& pipe) {
          run_and_send(level, scenario, images, Sender(pipe));
      }) {}

std::vector<LevelProcess::Picture> LevelProcess::receive() {
    std::vector<Picture> pictures;
    process_.receive(received_);
    take_messages(pictures);
    if (process_.ended()) end();
    return pictures;
}

void LevelProcess::take_messages(std::vector<Picture>& pictures) {
    std::size_t at = 0;
    LevelMessage message;
    while (received_.size() - at >= sizeof message) {
        std::memcpy(&message, received_.data() + at, sizeof message);
        if (received_.size() - at - sizeof message < message.bytes) break;
        take_message(message, received_.data() + at + sizeof message, pictures);
        at += sizeof message + message.bytes;
    }
    received_.erase(0, at);
}

void LevelProcess::take_message(const LevelMessage& message, const char* payload,
                                std::vector<Picture>& pictures) {
    switch (message.kind) {
        case LevelMessage::Kind::kPicture: {
            Picture picture{message.frame, message.display,
                            ColourImage(message.width_pixels, message.height_pixels)};
            std::memcpy(picture.image.values.data(), payload, message.bytes);
            pictures.push_back(std::move(picture));
            break;
        }
        case LevelMessage::Kind::kProgress:
            progress_ = message.number;
            break;
        case LevelMessage::Kind::kReport:
            result_ = Result{std::string(payload, message.bytes), message.core_cycles, message.number,
                             message.status != 0};
            break;
        case LevelMessage::Kind::kFailure:
            failure_ = Failure{static_cast<ExitStatus>(message.status), std::string(payload, message.bytes)};
            break;
    }
}

void LevelProcess::end() {
    const std::string& complaint = process_.complaint();
    if (failure_ || (result_ && complaint.empty())) return;
    result_.reset();
    failure_ = Failure{kExitModelError,
                       complaint.empty() ? "ended with exit status 0 and without a report" : complaint};
}

}  // namespace metabuffer
