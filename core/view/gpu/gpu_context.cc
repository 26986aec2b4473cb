#include "core/view/gpu/gpu_context.h"

#include <EGL/eglext.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace raywalk {
namespace {

constexpr GLint kStorageBlocks = 8;  // that programs here bind

template <typename Function>
Function extension(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

// The displays of all devices, those of cards as the drivers order them.
std::vector<EGLDisplay> displays() {
  std::vector<EGLDisplay> found;
  const auto query = extension<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
  const auto display_of = extension<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  std::array<EGLDeviceEXT, 64> devices{};
  EGLint count = 0;
  if (query != nullptr && display_of != nullptr &&
      query(static_cast<EGLint>(devices.size()), devices.data(), &count) == EGL_TRUE) {
    for (const EGLDeviceEXT device : std::span(devices).first(static_cast<std::size_t>(count))) {
      found.push_back(display_of(EGL_PLATFORM_DEVICE_EXT, device, nullptr));
    }
  }
  if (display_of != nullptr) {
    found.push_back(display_of(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
  }
  return found;
}

bool stands_in_for_a_card(const std::string& name) {
  const auto has = [&](const char* word) { return name.find(word) != std::string::npos; };
  return has("llvmpipe") || has("softpipe") || has("SwiftShader") || has("swrast");
}

std::string log_of(GLuint id, bool program) {
  std::array<char, 512> text{};
  if (program) {
    glGetProgramInfoLog(id, static_cast<GLsizei>(text.size()), nullptr, text.data());
  } else {
    glGetShaderInfoLog(id, static_cast<GLsizei>(text.size()), nullptr, text.data());
  }
  const std::string log = text.data();
  return log.substr(0, log.find('\n'));
}

}  // namespace

std::unique_ptr<GpuContext> GpuContext::open(bool software) {
  const std::vector<EGLDisplay> all = displays();
  for (const bool allowed : {false, true}) {
    if (allowed && !software) break;
    for (const EGLDisplay display : all) {
      std::unique_ptr<GpuContext> context(new GpuContext);
      if (context->try_display(display, allowed)) return context;
    }
  }
  throw GpuError("no graphics card with EGL and OpenGL ES 3.1");
}

bool GpuContext::try_display(EGLDisplay display, bool software) {
  if (display == EGL_NO_DISPLAY || eglInitialize(display, nullptr, nullptr) != EGL_TRUE ||
      eglBindAPI(EGL_OPENGL_ES_API) != EGL_TRUE) {
    return false;
  }
  const std::array<EGLint, 3> any{EGL_SURFACE_TYPE, EGL_DONT_CARE, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (eglChooseConfig(display, any.data(), &config, 1, &count) != EGL_TRUE || count == 0) {
    config = EGL_NO_CONFIG_KHR;
  }
  const std::array<EGLint, 5> version{EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 1,
                                      EGL_NONE};
  display_ = display;
  context_ = eglCreateContext(display, config, EGL_NO_CONTEXT, version.data());
  if (context_ == EGL_NO_CONTEXT ||
      eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) != EGL_TRUE) {
    return false;
  }
  const auto* const name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  name_ = name == nullptr ? "" : name;
  is_software_ = stands_in_for_a_card(name_);
  GLint blocks = 0;
  glGetIntegerv(GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS, &blocks);
  eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  return is_software_ == software && blocks >= kStorageBlocks;
}

GpuContext::~GpuContext() {
  if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
}

void GpuContext::Turn::take() {
  {
    std::unique_lock lock(context_->mutex_);
    const std::uint64_t ticket = context_->came_++;
    context_->passed_.wait(lock, [&] { return context_->gone_ == ticket; });
    held_ = true;
  }
  if (eglMakeCurrent(context_->display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_->context_) ==
      EGL_TRUE) {
    return;
  }
  pass();
  throw GpuError(context_->name_ + " cannot be used any more");
}

void GpuContext::Turn::pass() {
  if (!std::exchange(held_, false)) return;
  eglMakeCurrent(context_->display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  {
    const std::lock_guard lock(context_->mutex_);
    ++context_->gone_;
  }
  context_->passed_.notify_all();
}

void GpuContext::Turn::wait() {
  constexpr GLuint64 kPatience_ns = 200'000;  // before the next one who came has a turn
  const GLsync done = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  glFlush();
  GLenum state = GL_TIMEOUT_EXPIRED;
  while (state == GL_TIMEOUT_EXPIRED) {
    const bool others = [&] {
      const std::lock_guard lock(context_->mutex_);
      return context_->came_ > context_->gone_ + 1;
    }();
    if (others) {
      pass();
      take();
    }
    state = glClientWaitSync(done, 0, kPatience_ns);
  }
  glDeleteSync(done);
  if (state == GL_WAIT_FAILED) throw GpuError(context_->name_ + " failed");
}

void check_gpu(const char* what) {
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR) return;
  throw GpuError(error == GL_OUT_OF_MEMORY
                     ? fmt::format("too little memory of the card for {}", what)
                     : fmt::format("{} failed on the card (OpenGL error {:#x})", what, error));
}

const GpuProgram& GpuContext::program(const std::string& name, const std::string& defines,
                                      std::initializer_list<const char*> texts) {
  std::unique_ptr<GpuProgram>& program = programs_[name + defines];
  if (!program) {
    std::string whole = "#version 310 es\n" + defines;
    for (const char* text : texts) whole += text;
    program = std::make_unique<GpuProgram>(whole);
  }
  return *program;
}

GpuProgram::GpuProgram(const std::string& text) {
  const char* const source = text.c_str();
  const GLuint shader = glCreateShader(GL_COMPUTE_SHADER);
  glShaderSource(shader, 1, &source, nullptr);
  glCompileShader(shader);
  GLint done = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &done);
  if (done != GL_TRUE) {
    const std::string log = log_of(shader, false);
    glDeleteShader(shader);
    throw GpuError("the card's driver does not compile a program: " + log);
  }
  id_ = glCreateProgram();
  glAttachShader(id_, shader);
  glLinkProgram(id_);
  glDeleteShader(shader);
  glGetProgramiv(id_, GL_LINK_STATUS, &done);
  if (done == GL_TRUE) return;
  const std::string log = log_of(id_, true);
  glDeleteProgram(id_);
  throw GpuError("the card's driver does not link a program: " + log);
}

GpuProgram::~GpuProgram() { glDeleteProgram(id_); }

void run_groups(int across, int down) {
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
  glDispatchCompute(static_cast<GLuint>(across), static_cast<GLuint>(down), 1);
}

void run(int across, int down) {
  constexpr int kGroup = 8;
  run_groups((across + kGroup - 1) / kGroup, (down + kGroup - 1) / kGroup);
}

GpuBuffer::~GpuBuffer() {
  glDeleteBuffers(1, &id_);
  glDeleteBuffers(1, &copy_);
}

void GpuBuffer::reserve(std::size_t bytes) {
  if (id_ != 0 && bytes <= bytes_) return;
  GLint64 most = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  if (bytes > static_cast<std::uint64_t>(most)) {
    throw GpuError(
        fmt::format("the card takes at most {} MB of a picture's data", most / 1'000'000));
  }
  if (id_ == 0) glGenBuffers(1, &id_);
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, id_);
  const std::vector<std::byte> zeros(bytes);
  glBufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(bytes), zeros.data(),
               GL_DYNAMIC_COPY);
  check_gpu("a picture's data");
  bytes_ = bytes;
}

void GpuBuffer::write(std::size_t at, std::span<const std::byte> bytes) {
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, id_);
  glBufferSubData(GL_SHADER_STORAGE_BUFFER, static_cast<GLintptr>(at),
                  static_cast<GLsizeiptr>(bytes.size()), bytes.data());
}

void GpuBuffer::bind(GLuint binding) const {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, id_);
}

// Drivers may move what is mapped into the computer's memory for good.
void GpuBuffer::copy(std::size_t bytes) const {
  const auto size = static_cast<GLsizeiptr>(bytes);
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  if (copy_ == 0) glGenBuffers(1, &copy_);
  glBindBuffer(GL_COPY_WRITE_BUFFER, copy_);
  if (bytes > copy_bytes_) {
    glBufferData(GL_COPY_WRITE_BUFFER, size, nullptr, GL_STREAM_READ);
    copy_bytes_ = bytes;
  }
  glBindBuffer(GL_COPY_READ_BUFFER, id_);
  glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, 0, 0, size);
}

GpuBuffer::Mapped::Mapped(GLuint id, std::size_t size) : id(id) {
  glBindBuffer(GL_COPY_WRITE_BUFFER, id);
  bytes = static_cast<const std::byte*>(
      glMapBufferRange(GL_COPY_WRITE_BUFFER, 0, static_cast<GLsizeiptr>(size), GL_MAP_READ_BIT));
  check_gpu("reading a picture");
  if (bytes == nullptr) throw GpuError("a picture cannot be read from the card");
}

GpuBuffer::Mapped::~Mapped() {
  glBindBuffer(GL_COPY_WRITE_BUFFER, id);
  glUnmapBuffer(GL_COPY_WRITE_BUFFER);
}

}  // namespace raywalk
