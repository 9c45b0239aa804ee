#include "tools/bench/onednn_convolution.hpp"

#ifdef IMSLAM_ONEDNN

#include <omp.h>

#include <cstring>
#include <dnnl.hpp>
#include <memory>
#include <unordered_map>

namespace imslam::bench {
namespace {

using dnnl::convolution_backward_data;
using dnnl::convolution_backward_weights;
using dnnl::convolution_forward;
using dnnl::memory;
using Dims = memory::dims;
using Arguments = std::unordered_map<int, memory>;

constexpr auto kFloat = memory::data_type::f32;
constexpr auto kAny = memory::format_tag::any;
constexpr auto kDirect = dnnl::algorithm::convolution_direct;

struct Descriptions {
  memory::desc x, w, b, y;
  Dims strides, dilations, padding_begin, padding_end;
};

Dims pair(int y, int x) { return {y, x}; }

int padding_end(int in, int out, int stride, int kernel, int dilation, int begin) {
  return (out - 1) * stride + dilation * (kernel - 1) + 1 - in - begin;
}

Descriptions describe(const nn::ConvolutionShape& s) {
  return {{{s.batch, s.in_channels, s.in_height, s.in_width}, kFloat, kAny},
          {{s.out_channels, s.in_channels, s.kernel_height, s.kernel_width}, kFloat, kAny},
          {{s.out_channels}, kFloat, memory::format_tag::a},
          {{s.batch, s.out_channels, s.out_height(), s.out_width()}, kFloat, kAny},
          pair(s.stride_y, s.stride_x),
          pair(s.dilation_y - 1, s.dilation_x - 1),
          pair(s.padding_y, s.padding_x),
          pair(padding_end(s.in_height, s.out_height(), s.stride_y, s.kernel_height, s.dilation_y,
                           s.padding_y),
               padding_end(s.in_width, s.out_width(), s.stride_x, s.kernel_width, s.dilation_x,
                           s.padding_x))};
}

memory filled(const memory::desc& description, const dnnl::engine& engine) {
  memory array(description, engine);
  auto* values = static_cast<float*>(array.get_data_handle());
  const std::size_t count = description.get_size() / sizeof(float);
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<float>(i % 17) * 0.1F - 0.8F;
  return array;
}

std::function<void()> runner(const dnnl::primitive& primitive,
                             const dnnl::engine& engine,
                             const Arguments& arguments) {
  dnnl::stream stream(engine);
  return [primitive, stream, arguments]() mutable {
    primitive.execute(stream, arguments);
    stream.wait();
  };
}

}  // namespace

std::function<void()> onednn_convolution(const nn::ConvolutionShape& shape, Pass pass) {
  const dnnl::engine engine(dnnl::engine::kind::cpu, 0);
  const Descriptions d = describe(shape);
  const convolution_forward::primitive_desc forward(
      {dnnl::prop_kind::forward_training, kDirect, d.x, d.w, d.b, d.y, d.strides, d.dilations,
       d.padding_begin, d.padding_end},
      engine);
  const auto array = [&engine](const memory::desc& description) {
    return filled(description, engine);
  };
  if (pass == Pass::kForward) {
    return runner(convolution_forward(forward), engine,
                  {{DNNL_ARG_SRC, array(forward.src_desc())},
                   {DNNL_ARG_WEIGHTS, array(forward.weights_desc())},
                   {DNNL_ARG_BIAS, array(forward.bias_desc())},
                   {DNNL_ARG_DST, array(forward.dst_desc())}});
  }
  if (pass == Pass::kBackwardData) {
    const convolution_backward_data::primitive_desc backward(
        {kDirect, d.x, d.w, d.y, d.strides, d.dilations, d.padding_begin, d.padding_end}, engine,
        forward);
    return runner(convolution_backward_data(backward), engine,
                  {{DNNL_ARG_DIFF_SRC, array(backward.diff_src_desc())},
                   {DNNL_ARG_WEIGHTS, array(backward.weights_desc())},
                   {DNNL_ARG_DIFF_DST, array(backward.diff_dst_desc())}});
  }
  const convolution_backward_weights::primitive_desc backward(
      {kDirect, d.x, d.w, d.b, d.y, d.strides, d.dilations, d.padding_begin, d.padding_end}, engine,
      forward);
  return runner(convolution_backward_weights(backward), engine,
                {{DNNL_ARG_SRC, array(backward.src_desc())},
                 {DNNL_ARG_DIFF_WEIGHTS, array(backward.diff_weights_desc())},
                 {DNNL_ARG_DIFF_BIAS, array(backward.diff_bias_desc())},
                 {DNNL_ARG_DIFF_DST, array(backward.diff_dst_desc())}});
}

void limit_onednn(nn::InstructionSet set) {
  constexpr dnnl::cpu_isa kSets[] = {dnnl::cpu_isa::sse41, dnnl::cpu_isa::avx2,
                                     dnnl::cpu_isa::avx512_core};
  dnnl::set_max_cpu_isa(kSets[static_cast<int>(set)]);
}

void set_onednn_threads(int threads) { omp_set_num_threads(threads); }

}  // namespace imslam::bench

#else

namespace imslam::bench {

std::function<void()> onednn_convolution(const nn::ConvolutionShape& /*shape*/, Pass /*pass*/) {
  return {};
}

void limit_onednn(nn::InstructionSet /*set*/) {}
void set_onednn_threads(int /*threads*/) {}

}  // namespace imslam::bench

#endif
