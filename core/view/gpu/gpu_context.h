// A graphics card, without a window: EGL without a surface and OpenGL ES 3.1, which the drivers of
// NVIDIA, AMD, Intel and Mesa have.
#pragma once

#include <EGL/egl.h>
#include <GLES3/gl31.h>

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>

#include "core/base/error.h"
#include "core/geometry/sphere.h"

namespace raywalk {

// Why a card cannot do something; the processor does it then.
class GpuError : public Error {
 public:
  using Error::Error;
};

// What follows, but GpuContext itself, is used during a Turn. Each throws GpuError where the card
// fails.

// Throws what OpenGL reports of the calls before.
void check_gpu(const char* what);

// A compute program.
class GpuProgram {
 public:
  explicit GpuProgram(const std::string& text);
  ~GpuProgram();
  GpuProgram(const GpuProgram&) = delete;
  GpuProgram& operator=(const GpuProgram&) = delete;

  void use() const { glUseProgram(id_); }
  // While it is used.
  void set(const char* name, int value) const { glUniform1i(at(name), value); }
  void set(const char* name, bool value) const { glUniform1i(at(name), value ? 1 : 0); }
  void set(const char* name, float value) const { glUniform1f(at(name), value); }
  void set(const char* name, int x, int y) const { glUniform2i(at(name), x, y); }
  void set(const char* name, PanoramaSize size) const { set(name, size.width, size.height); }
  void set(const char* name, const Eigen::Vector3d& value) const {
    glUniform3fv(at(name), 1, value.cast<float>().eval().data());
  }
  GLint at(const char* name) const { return glGetUniformLocation(id_, name); }

 private:
  GLuint id_ = 0;
};

class GpuContext {
 public:
  // The first device that has what is needed, a card before a program that stands in for one
  // (Mesa's llvmpipe), which `software` allows. Throws GpuError where there is none.
  static std::unique_ptr<GpuContext> open(bool software);
  ~GpuContext();
  GpuContext(const GpuContext&) = delete;
  GpuContext& operator=(const GpuContext&) = delete;

  // The driver's name of the device.
  const std::string& name() const { return name_; }
  bool is_software() const { return is_software_; }

  // The compute program of these texts, one after the other, `defines` before them: made once, and
  // known by its name and `defines`. During a Turn.
  const GpuProgram& program(const std::string& name, const std::string& defines,
                            std::initializer_list<const char*> texts);

  // OpenGL may be used by the thread that holds one, by one at a time, in the order they came.
  class Turn {
   public:
    explicit Turn(GpuContext* context) : context_(context) { take(); }
    ~Turn() { pass(); }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

    // Returns when the card has done all that was asked of it. Others have turns meanwhile, so that
    // the card has work: what was bound or set may be gone, and textures may hold other images.
    void wait();

   private:
    void take();
    void pass();

    GpuContext* context_;
    bool held_ = false;
  };

 private:
  GpuContext() = default;
  bool try_display(EGLDisplay display, bool software);

  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
  std::string name_;
  bool is_software_ = false;
  std::map<std::string, std::unique_ptr<GpuProgram>> programs_;

  std::mutex mutex_;  // of what follows
  std::condition_variable passed_;
  std::uint64_t came_ = 0, gone_ = 0;  // turns that were asked for, and that ended
};

// Runs the program in use, after those before it, for so many groups of invocations, and for groups
// of 8 x 8 that make up so many invocations.
void run_groups(int across, int down);
void run(int across, int down);

// Memory of the card that programs read or write.
class GpuBuffer {
 public:
  GpuBuffer() = default;
  ~GpuBuffer();
  GpuBuffer(const GpuBuffer&) = delete;
  GpuBuffer& operator=(const GpuBuffer&) = delete;

  // Room for so many bytes; if it grows, what it held is lost, and all are 0.
  void reserve(std::size_t bytes);
  void write(std::size_t at, std::span<const std::byte> bytes);
  template <typename Value>
  void write(std::span<const Value> values) {
    reserve(std::max(values.size_bytes(), std::size_t{16}));
    write(0, std::as_bytes(values));
  }
  void bind(GLuint binding) const;
  // Calls `use` with what was written to the first bytes, when it is done; with a turn, others have
  // theirs until then.
  template <typename Use>
  void read(std::size_t bytes, const Use& use, GpuContext::Turn* turn = nullptr) const {
    copy(bytes);
    if (turn != nullptr) turn->wait();
    const Mapped mapped(copy_, bytes);
    use(mapped.bytes);
  }

 private:
  struct Mapped {
    Mapped(GLuint id, std::size_t size);
    ~Mapped();
    Mapped(const Mapped&) = delete;
    Mapped& operator=(const Mapped&) = delete;
    GLuint id;
    const std::byte* bytes;
  };
  void copy(std::size_t bytes) const;

  GLuint id_ = 0;
  std::size_t bytes_ = 0;
  mutable GLuint copy_ = 0;  // that is read
  mutable std::size_t copy_bytes_ = 0;
};

}  // namespace raywalk
