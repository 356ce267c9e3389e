#include "rtl/waveform_file.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "host/errors.h"
#include "host/temporary_folder.h"
#include "rtl/fst_converter.h"

namespace metabuffer::rtl {
namespace {

constexpr const char* kStem = "waveform";
constexpr std::string_view kAllWritten = "all written";

/// The text as a comment in a value change dump; the word $end ends such a comment. line_by_line: each line as a
/// comment of its own, since GTKWave's format keeps a comment's first line only.
std::string as_comment(std::string text, bool line_by_line) {
    std::replace(text.begin(), text.end(), '$', '?');
    if (!line_by_line) return "$comment\n" + text + "$end\n";
    std::string comments;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) comments += "$comment\n" + line + "\n$end\n";
    return comments;
}

/// Puts the time before the first values of a value change dump. SystemC writes none, and readers take them for values
/// of time 0.
class FirstTime {
  public:
    explicit FirstTime(std::int64_t picoseconds) : line_("#" + std::to_string(picoseconds) + "\n") {}

    /// What is to be written of the next bytes.
    std::string after(std::string_view bytes) {
        if (is_written_) return std::string(bytes);
        held_ += bytes;
        const std::size_t values = held_.find(kValues);
        if (values == std::string::npos) return {};
        is_written_ = true;
        return std::move(held_.insert(values + 1, line_));
    }
    /// What has been held back for values that have not come.
    std::string rest() { return is_written_ ? std::string() : std::move(held_); }

  private:
    static constexpr std::string_view kValues = "\n$dumpvars";

    std::string line_;
    std::string held_;
    bool is_written_ = false;
};

bool is_fst(const std::filesystem::path& file) { return file.extension() == kCompressedWaveformExtension; }

}  // namespace

bool is_waveform_name(const std::filesystem::path& file) {
    return file.extension() == kWaveformExtension || is_fst(file);
}

class WaveformFile::Pipe {
  public:
    explicit Pipe(const std::filesystem::path& target) {
        try {
            folder_.emplace();
        } catch (const std::system_error& error) {
            fail(target, error.code().value());
        }
        // Opened before its writer comes, so that neither end waits for the other for ever.
        if (mkfifo((stem() + kWaveformExtension).c_str(), 0600) != 0 ||
            (reading_ = open((stem() + kWaveformExtension).c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) < 0) {
            fail(target, errno);
        }
        before_ = std::signal(SIGPIPE, SIG_IGN);
    }
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;
    ~Pipe() {
        std::signal(SIGPIPE, before_);
        close_reading();
    }

    std::string stem() const { return (folder_->path() / kStem).string(); }

    /// For the process that writes the file: calls take(bytes) with all that comes, until the pipe's writer closes it.
    template <typename Take>
    void read_all(Take take) const {
        std::array<pollfd, 1> polled{{{reading_, POLLIN, 0}}};
        while (poll(polled.data(), polled.size(), -1) < 0 && errno == EINTR) {
        }
        fcntl(reading_, F_SETFL, 0);
        std::array<char, std::size_t{1} << 16> buffer{};
        for (;;) {
            const ssize_t count = read(reading_, buffer.data(), buffer.size());
            if (count == 0) return;
            if (count > 0) {
                take(std::string_view(buffer.data(), static_cast<std::size_t>(count)));
            } else if (errno != EINTR) {
                throw OutputError("the waveform's pipe: " + std::generic_category().message(errno));
            }
        }
    }

    /// For the process that simulates: from now on writing fails if the process at the other end has ended. Once both
    /// ends are open the pipe needs no name, so its folder is removed now.
    void close_reading() {
        if (!folder_) return;
        close(reading_);
        folder_.reset();
    }

  private:
    [[noreturn]] static void fail(const std::filesystem::path& target, int error) {
        fail_to_write(target, "no pipe for it: " + std::generic_category().message(error));
    }

    std::optional<TemporaryFolder> folder_;
    int reading_ = -1;
    void (*before_)(int) = nullptr;
};

WaveformFile::WaveformFile(const std::filesystem::path& target, const std::string& header)
    : target_(target), header_(header), output_(target) {
    if (is_fst(target)) FstConverter::check_installed(target);
}

void WaveformFile::start(std::int64_t first_picoseconds) {
    first_picoseconds_ = first_picoseconds;
    pipe_ = std::make_unique<Pipe>(target_);
    writer_ = std::make_unique<ChildProcess>([this](const ChildProcess::Sender& sender) {
        const std::string answer = write_all();
        sender.send(answer.data(), answer.size());
    });
}

/// Writes all that comes, the header first. After a failure it still reads, since the simulation waits for that.
/// Returns kAllWritten or the error.
std::string WaveformFile::write_all() {
    std::string answer(kAllWritten);
    const auto unless_failed = [&answer](const auto& step) {
        if (answer != kAllWritten) return;
        try {
            step();
        } catch (const OutputError& error) {
            answer = error.what();
        }
    };
    std::optional<FstConverter> converter;
    const auto write = [&](std::string_view bytes) {
        unless_failed([&] {
            if (converter) return converter->write(bytes);
            output_.write(bytes);
        });
    };
    if (is_fst(target_)) unless_failed([&] { converter.emplace(); });
    write(as_comment(header_, is_fst(target_)));
    FirstTime first(first_picoseconds_);
    try {
        pipe_->read_all([&](std::string_view bytes) { write(first.after(bytes)); });
    } catch (const OutputError& error) {
        answer = error.what();
    }
    write(first.rest());
    if (converter) unless_failed([&] { converter->finish(output_); });
    return answer;
}

WaveformFile::~WaveformFile() = default;

std::string WaveformFile::stem() const { return pipe_->stem(); }

void WaveformFile::note_opened() { pipe_->close_reading(); }

void WaveformFile::put_in_place() {
    std::string answer;
    while (!writer_->ended()) writer_->receive(answer);
    if (answer == kAllWritten && writer_->complaint().empty()) {
        output_.put_in_place();
        return;
    }
    if (!answer.empty() && answer != kAllWritten) throw OutputError(answer);
    fail_to_write(target_, "its process " + writer_->complaint());
}

}  // namespace metabuffer::rtl
