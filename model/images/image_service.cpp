#include "images/image_service.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/child_process.h"
#include "host/errors.h"
#include "host/message_channel.h"
#include "host/quiet_fork.h"
#include "host/text.h"
#include "images/image_module.h"

namespace metabuffer {
namespace {

/// The other end of a connection is gone.
struct Disconnected {};

constexpr const char* kNoImages = "images can be neither read nor written: ";

/// Whether this process may start `processes` more, all alive at the same time.
bool can_start(std::size_t processes) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) return false;
    std::vector<pid_t> children;
    pid_t child = 0;
    while (children.size() < processes && (child = fork()) > 0) children.push_back(child);
    if (child == 0 && children.size() < processes) {
        // Waits until the parent has closed its end, in whatever way.
        close(ends[1]);
        char nothing = 0;
        static_cast<void>(!read(ends[0], &nothing, 1));
        _exit(0);
    }
    close(ends[0]);
    close(ends[1]);
    for (const pid_t started : children) {
        while (waitpid(started, nullptr, 0) < 0 && errno == EINTR) {
        }
    }
    return children.size() == processes;
}

/// While it lives, this process may use no more than so many seconds of the processor.
class ProcessorLimit {
  public:
    explicit ProcessorLimit(rlim_t seconds) {
        getrlimit(RLIMIT_CPU, &before_);
        rlimit limit = before_;
        if (seconds < limit.rlim_cur) limit.rlim_cur = seconds;
        setrlimit(RLIMIT_CPU, &limit);
    }
    ProcessorLimit(const ProcessorLimit&) = delete;
    ProcessorLimit& operator=(const ProcessorLimit&) = delete;
    ~ProcessorLimit() { setrlimit(RLIMIT_CPU, &before_); }

  private:
    rlimit before_{};
};

[[noreturn]] void fail_to_load() {
    const char* why = dlerror();
    throw InputError(text::one_line(
        std::string(kNoImages) + (why == nullptr ? "no reason given" : why) +
        "; is there enough memory, and is all of metabuffer built or installed, for this user to read?"));
}

const ImageCodec& loaded_codec() {
    const ProcessorLimit limit(ImageService::kMostLoadingProcessorSeconds);
    // Where one of the libraries brings OpenBLAS along, it would start a thread for each processor, and with little memory
    // try for ever.
    setenv("OPENBLAS_NUM_THREADS", "1", 1);
    setenv("OMP_NUM_THREADS", "1", 1);
    // Others start a few, and wait for ever for those that they cannot start.
    constexpr std::size_t kThreads = 6;
    if (!can_start(kThreads)) {
        throw InputError(
            "metabuffer: this computer refuses the threads that OpenImageIO's libraries start; raise its "
            "limit on processes");
    }
    // By its name: the program says where its modules are, built or installed.
    void* module = dlopen(kImageModuleFile, RTLD_LAZY | RTLD_LOCAL);
    if (module == nullptr) fail_to_load();
    void* entry = dlsym(module, kImageModuleEntry);
    if (entry == nullptr) fail_to_load();
    return *reinterpret_cast<ImageModuleEntry*>(entry)();
}

/// Throws what the other process threw. What it does not name is a lack of memory.
void check(const std::string& ending) {
    if (!is_done(ending)) throw std::bad_alloc();
}

/// Whether there is something to receive within this time, if only that the other end is gone.
bool comes_within(int seconds, int descriptor) {
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::seconds(seconds);
    pollfd wanted{descriptor, POLLIN, 0};
    for (;;) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
        const int ready = poll(&wanted, 1, static_cast<int>(std::max<std::int64_t>(left, 0)));
        if (ready >= 0 || errno != EINTR) return ready > 0;
    }
}

/// A message with room for a descriptor. A socket passes descriptors only with a byte of data.
struct DescriptorMessage {
    char nothing = 0;
    iovec data{&nothing, sizeof nothing};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
    msghdr header{};

    DescriptorMessage() {
        header.msg_iov = &data;
        header.msg_iovlen = 1;
        header.msg_control = control.data();
        header.msg_controllen = control.size();
    }
    DescriptorMessage(const DescriptorMessage&) = delete;
    DescriptorMessage& operator=(const DescriptorMessage&) = delete;
};

/// Sends a descriptor through a socket that keeps messages whole. False if nobody receives any more.
bool send_descriptor(int socket, int descriptor) {
    DescriptorMessage message;
    cmsghdr* const content = CMSG_FIRSTHDR(&message.header);
    content->cmsg_level = SOL_SOCKET;
    content->cmsg_type = SCM_RIGHTS;
    content->cmsg_len = CMSG_LEN(sizeof descriptor);
    std::memcpy(CMSG_DATA(content), &descriptor, sizeof descriptor);
    ssize_t sent = 0;
    do {
        sent = sendmsg(socket, &message.header, MSG_NOSIGNAL);
    } while (sent < 0 && errno == EINTR);
    return sent == 1;
}

/// The next one; -1 if none comes any more.
int received_descriptor(int socket) {
    DescriptorMessage message;
    ssize_t got = 0;
    do {
        got = recvmsg(socket, &message.header, MSG_CMSG_CLOEXEC);
    } while (got < 0 && (errno == EINTR || errno == ECONNRESET));
    const cmsghdr* const content = got == 1 ? CMSG_FIRSTHDR(&message.header) : nullptr;
    int descriptor = -1;
    if (content != nullptr) std::memcpy(&descriptor, CMSG_DATA(content), sizeof descriptor);
    return descriptor;
}

}  // namespace

enum class ImageService::Operation : std::uint8_t { kSize, kLoad, kPng, kColourTiff, kDepthTiff };

/// One end of a connection. Its functions throw Disconnected.
class ImageService::Stream {
  public:
    explicit Stream(int descriptor) : descriptor_(descriptor) {}
    Stream(Stream&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
    Stream& operator=(Stream&&) = delete;
    ~Stream() {
        if (descriptor_ >= 0) close(descriptor_);
    }

    int descriptor() const { return descriptor_; }

    template <typename Value>
    void put(const Value& value) {
        static_assert(std::is_trivially_copyable_v<Value>);
        put_bytes(&value, sizeof value);
    }
    template <typename Value>
    Value get() {
        static_assert(std::is_trivially_copyable_v<Value>);
        Value value{};
        get_bytes(&value, sizeof value);
        return value;
    }
    void put_text(const std::string& text) {
        put(text.size());
        put_bytes(text.data(), text.size());
    }
    std::string get_text() {
        std::string text(get<std::size_t>(), '\0');
        get_bytes(text.data(), text.size());
        return text;
    }
    template <typename Value>
    void put_raster(const Raster<Value>& raster) {
        put(raster.width_pixels);
        put(raster.height_pixels);
        put_bytes(raster.values.data(), raster.values.size() * sizeof(Value));
    }
    template <typename Value>
    Raster<Value> get_raster() {
        const int width = get<int>();
        const int height = get<int>();
        Raster<Value> image(width, height);
        get_bytes(image.values.data(), image.values.size() * sizeof(Value));
        return image;
    }
    void put_files(const ImageFiles& files) {
        put_text(files.image.string());
        put_optional(files.depth, [this](const auto& depth) { put_text(depth.string()); });
        put_optional(files.z, [this](double z) { put(z); });
        put_optional(files.layer, [this](const auto& layer) { put_text(layer); });
        put_optional(files.depth_layer, [this](const auto& layer) { put_text(layer); });
    }
    ImageFiles get_files() {
        ImageFiles files{get_text()};
        if (get<bool>()) files.depth = get_text();
        if (get<bool>()) files.z = get<double>();
        if (get<bool>()) files.layer = get_text();
        if (get<bool>()) files.depth_layer = get_text();
        return files;
    }
    void put_reading(const ImageReading& reading) {
        put(reading.near);
        put(reading.far);
        put(reading.integers);
        put(reading.bits);
        put(reading.colours);
        put(reading.nothing.size());
        for (const double sample : reading.nothing) put(sample);
        put(reading.nan_is_nothing);
    }
    ImageReading get_reading() {
        ImageReading reading{get<double>(), get<double>(), get<DepthIntegers>(), get<DepthBits>(),
                             get<ColourEncoding>()};
        reading.nothing.resize(get<std::size_t>());
        for (double& sample : reading.nothing) sample = get<double>();
        reading.nan_is_nothing = get<bool>();
        return reading;
    }

  private:
    template <typename Value, typename Put>
    void put_optional(const std::optional<Value>& value, Put put_value) {
        put(value.has_value());
        if (value) put_value(*value);
    }
    void put_bytes(const void* bytes, std::size_t count) const {
        const char* at = static_cast<const char*>(bytes);
        while (count > 0) {
            const ssize_t sent = send(descriptor_, at, count, MSG_NOSIGNAL);
            if (sent < 0 && errno == EINTR) continue;
            if (sent <= 0) throw Disconnected();
            at += sent;
            count -= static_cast<std::size_t>(sent);
        }
    }
    void get_bytes(void* bytes, std::size_t count) const {
        char* at = static_cast<char*>(bytes);
        while (count > 0) {
            const ssize_t got = recv(descriptor_, at, count, 0);
            if (got < 0 && errno == EINTR) continue;
            if (got <= 0) throw Disconnected();
            at += got;
            count -= static_cast<std::size_t>(got);
        }
    }

    int descriptor_;
};

struct ImageService::EncodingRequest {
    Operation operation{};
    std::filesystem::path file{};
    std::string description{};
    DepthFormat format{};
};

/// What the service's processes do.
class ImageService::Server {
  public:
    /// Loads the libraries, and forks a server for each connection that comes through the socket.
    static void serve(int socket, int pipe) {
        // Its program ends this process. Ctrl-C is for the program, which may still write pictures.
        for (const int number : {SIGINT, SIGTERM, SIGHUP}) std::signal(number, SIG_IGN);
        // libpng, libtiff and others print what they also report to their caller.
        be_silent();
        dup2(STDERR_FILENO, STDOUT_FILENO);
        const ImageCodec* codec = nullptr;
        const std::string loaded = ending_of([&codec] { codec = &loaded_codec(); });
        std::signal(SIGCHLD, SIG_IGN);  // nobody waits for the servers
        const pid_t service = getpid();
        for (int descriptor = received_descriptor(socket); descriptor >= 0;
             descriptor = received_descriptor(socket)) {
            Stream stream(descriptor);
            const pid_t server = codec == nullptr ? -1 : quiet_fork();
            const int error = errno;
            if (server > 0) continue;
            if (server == 0) {
                close(socket);
                close(pipe);  // which says when the service has ended
                prctl(PR_SET_PDEATHSIG, SIGKILL);
                stream.put_text(loaded);
                if (getppid() == service) Server(stream, *codec).answer();
                return;
            }
            try {
                stream.put_text(codec == nullptr ? loaded : ending_of([error] {
                    throw InputError(std::string(kNoImages) + std::strerror(error));
                }));
            } catch (const Disconnected&) {
                // Who asked has ended.
            }
        }
    }

  private:
    Server(Stream& stream, const ImageCodec& codec) : stream_(stream), codec_(codec) {}

    /// Answers one question after another until the other end is gone.
    [[noreturn]] void answer() {
        for (;;) {
            switch (const auto operation = stream_.get<Operation>()) {
                case Operation::kSize:
                    answer_size();
                    break;
                case Operation::kLoad:
                    answer_load();
                    break;
                case Operation::kPng:
                case Operation::kColourTiff:
                case Operation::kDepthTiff:
                    answer_encoding(operation);
                    break;
            }
        }
    }
    void answer_size() {
        const ImageFiles files = stream_.get_files();
        ImageSize size;
        if (did([&] { size = codec_.size(files); })) stream_.put(size);
    }
    void answer_load() {
        const ImageFiles files = stream_.get_files();
        const auto format = stream_.get<DepthFormat>();
        const ImageReading reading = stream_.get_reading();
        ReadImage image;
        if (!did([&] { image = codec_.load(files, format, reading); })) return;
        stream_.put_raster<Pixel>(image);
        stream_.put(image.clamped);
    }
    void answer_encoding(Operation operation) {
        EncodingRequest request{operation, stream_.get_text()};
        request.description = stream_.get_text();
        request.format = stream_.get<DepthFormat>();
        std::string bytes;
        bool is_done = false;
        if (operation == Operation::kPng) {
            const ColourImage image = stream_.get_raster<std::uint32_t>();
            is_done = did([&] { bytes = codec_.png(image, request.file, request.description); });
        } else {
            const PixelImage image = stream_.get_raster<Pixel>();
            is_done = did([&] {
                bytes = operation == Operation::kDepthTiff
                            ? codec_.depth_tiff(image, request.format, request.file)
                            : codec_.colour_tiff(image, request.file);
            });
        }
        if (is_done) stream_.put_text(bytes);
    }

    /// Does the work and sends how it ended. Whether it is done.
    bool did(const std::function<void()>& work) {
        bool done = false;
        stream_.put_text(ending_of([&] {
            work();
            done = true;
        }));
        return done;
    }

    Stream& stream_;
    const ImageCodec& codec_;
};

/// The process that has the libraries, and the socket to it.
class ImageService::Process {
  public:
    Process()
        : process_([this](const ChildProcess::Sender& pipe) {
              channel_.be_child();
              close_descriptors_but({channel_.descriptor(), pipe.descriptor()});
              try {
                  Server::serve(channel_.descriptor(), pipe.descriptor());
              } catch (const Disconnected&) {
                  // So ends a server.
              }
          }) {
        channel_.be_parent();
    }

    bool is_of_this_process() const { return owner_ == getpid(); }
    /// False if it has ended.
    bool give(int descriptor) const { return send_descriptor(channel_.descriptor(), descriptor); }
    /// How it has ended, if it has.
    std::string how_it_ended() {
        constexpr int kSecondsForIt = 1;
        std::string nothing;
        if (comes_within(kSecondsForIt, process_.descriptor())) process_.receive(nothing);
        return process_.complaint().empty() ? "gives no answer" : process_.complaint();
    }

    /// Whether a connection has ever been answered.
    bool has_loaded = false;

  private:
    pid_t owner_ = getpid();
    MessageChannel channel_;
    ChildProcess process_;
};

ImageService::ImageService() : process_(std::make_unique<Process>()) {}

ImageService::~ImageService() { give_up(); }

void ImageService::give_up() const {
    stream_.reset();
    // A child leaves its parent's process alone.
    if (process_ != nullptr && !process_->is_of_this_process()) static_cast<void>(process_.release());
    process_.reset();
}

/// A new connection of this process. If the service has been killed, another one is started.
ImageService::Stream ImageService::connect() const {
    std::array<int, 2> ends{};
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
        throw InputError(std::string(kNoImages) + std::strerror(errno));
    }
    Stream own(ends[0]);
    const Stream others(ends[1]);
    if (process_ == nullptr || !process_->give(ends[1])) {
        give_up();
        process_ = std::make_unique<Process>();
        process_->give(ends[1]);
    }
    return own;
}

ImageService::Stream& ImageService::stream() const {
    if (stream_ != nullptr && connected_ == getpid()) return *stream_;
    auto stream = std::make_unique<Stream>(connect());
    if (!comes_within(kMostLoadingSeconds, stream->descriptor())) {
        give_up();
        throw InputError(kNoImages + std::string("OpenImageIO's libraries are not loaded after ") +
                         std::to_string(kMostLoadingSeconds) + " s; is there enough memory?");
    }
    std::string loaded;
    try {
        loaded = stream->get_text();
    } catch (const Disconnected&) {
        if (process_->has_loaded) throw;  // killed since then
        const std::string how = process_->how_it_ended();
        give_up();
        throw InputError(kNoImages + std::string("the process that loads OpenImageIO's libraries ") + how +
                         "; is there enough memory?");
    }
    try {
        check(loaded);
    } catch (...) {
        give_up();  // the next one may have more luck
        throw;
    }
    process_->has_loaded = true;
    stream_ = std::move(stream);
    connected_ = getpid();
    return *stream_;
}

/// Asks on this process's connection. A process that has gone may have been killed, so another is asked the same.
void ImageService::ask(const std::filesystem::path& file,
                       const std::function<void(Stream&)>& question) const {
    constexpr int kTries = 2;
    for (int n = 0; n < kTries; ++n) {
        try {
            return question(stream());
        } catch (const Disconnected&) {
            stream_.reset();
        } catch (...) {
            stream_.reset();  // there may be more to receive
            throw;
        }
    }
    throw InputError(text::quoted(file.string()) +
                     ": the process that reads and writes images ended over it twice");
}

ImageSize ImageService::size(const ImageFiles& files) const {
    ImageSize size;
    ask(files.image, [&](Stream& to) {
        to.put(Operation::kSize);
        to.put_files(files);
        check(to.get_text());
        size = to.get<ImageSize>();
    });
    return size;
}

ReadImage ImageService::load(const ImageFiles& files, DepthFormat format, const ImageReading& reading) const {
    ReadImage image;
    ask(files.image, [&](Stream& to) {
        to.put(Operation::kLoad);
        to.put_files(files);
        to.put(format);
        to.put_reading(reading);
        check(to.get_text());
        image = to.get_raster<Pixel>();
        image.clamped = to.get<ClampedDepths>();
    });
    return image;
}

template <typename Value>
std::string ImageService::encoded(const EncodingRequest& request, const Raster<Value>& image) const {
    std::string bytes;
    ask(request.file, [&](Stream& to) {
        to.put(request.operation);
        to.put_text(request.file.string());
        to.put_text(request.description);
        to.put(request.format);
        to.put_raster(image);
        check(to.get_text());
        bytes = to.get_text();
    });
    return bytes;
}

std::string ImageService::png(const ColourImage& image, const std::filesystem::path& file,
                              const std::string& description) const {
    return encoded({Operation::kPng, file, description}, image);
}

std::string ImageService::colour_tiff(const PixelImage& image, const std::filesystem::path& file) const {
    return encoded({Operation::kColourTiff, file}, image);
}

std::string ImageService::depth_tiff(const PixelImage& image, DepthFormat format,
                                     const std::filesystem::path& file) const {
    return encoded({Operation::kDepthTiff, file, {}, format}, image);
}

}  // namespace metabuffer
