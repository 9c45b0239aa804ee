#!/usr/bin/env python3
"""PyTorch's times of what our benchmarks measure: one request per line, one line in answer.

    threads COUNT                                                     ready
    convolution N H W CIN COUT KY KX SY SX PY PX DY DX PASS           ready
    encoder WEIGHTS N H W PASS                                        ready SUM2 SUM4 SUM8 SUM16
    time CALLS                                                        CALLS times [s]

PASS is forward, backward_data, backward_weights; of the encoder forward or both. The arrays lie in
whichever of PyTorch's two memory formats is the faster. Of one thread processor time, of several
wall time. The sums tell whether the encoder computes what ours does.
"""
import json
import struct
import sys
import time

try:
    import numpy
    import torch
    from torch.nn import functional
except ImportError as missing:
    sys.exit(str(missing))

NORM_EPSILON = 1e-5
SMALLEST_SQUARE = 1e-12
FORMATS = (torch.contiguous_format, torch.channels_last)


def seconds():
    one = torch.get_num_threads() == 1
    return time.clock_gettime(time.CLOCK_PROCESS_CPUTIME_ID if one else time.CLOCK_MONOTONIC)


def timed(call, calls):
    call()
    times = []
    for _ in range(calls):
        start = seconds()
        call()
        times.append(seconds() - start)
    return times


def convolution(words, memory):
    n, h, w, cin, cout, ky, kx, sy, sx, py, px, dy, dx = map(int, words[:-1])
    x = torch.rand(n, cin, h, w).to(memory_format=memory)
    weight = torch.rand(cout, cin, ky, kx).to(memory_format=memory)
    bias = torch.rand(cout)
    stride, padding, dilation = (sy, sx), (py, px), (dy, dx)

    def forward():
        with torch.inference_mode():
            return functional.conv2d(x, weight, bias, stride, padding, dilation)

    if words[-1] == 'forward':
        return forward
    gradient = torch.ones_like(forward()).to(memory_format=memory)
    wanted = [True, False, False] if words[-1] == 'backward_data' else [False, True, True]
    return lambda: torch.ops.aten.convolution_backward(
        gradient, x, weight, [cout], stride, padding, dilation, False, (0, 0), 1, wanted)


def read_tensors(path):
    """The tensors of a safetensors file, as float32."""
    with open(path, 'rb') as file:
        header = json.loads(file.read(struct.unpack('<Q', file.read(8))[0]))
        data = file.read()
    header.pop('__metadata__', None)
    kinds = {'F16': numpy.float16, 'F32': numpy.float32}
    tensors = {}
    for name, entry in header.items():
        begin, end = entry['data_offsets']
        numbers = numpy.frombuffer(data[begin:end], kinds[entry['dtype']]).reshape(entry['shape'])
        tensors[name] = torch.from_numpy(numbers.astype(numpy.float32))
    return tensors


class Encoder:
    """vo_net/encoder.hpp with its norms folded into the convolutions."""

    def __init__(self, path, memory):
        self.tensors = read_tensors(path)
        self.weights = {}
        for key in [k for k in self.tensors if k.startswith('encoder.') and k.endswith('.weight')]:
            self.fold(key[len('encoder.'):-len('.weight')], memory)

    def fold(self, name, memory):
        get = lambda part: self.tensors[f'encoder.{part}']
        weight = get(f'{name}.weight').permute(3, 2, 0, 1)
        bias = get(f'{name}.bias')
        block = name[:-len('.conv')]
        folds = name.endswith('.conv')
        if folds:
            slope = get(f'{block}.norm.gain') / torch.sqrt(
                get(f'{block}.norm.running_variance') + NORM_EPSILON)
            weight = weight * slope.reshape(-1, 1, 1, 1)
            bias = (bias - get(f'{block}.norm.running_mean')) * slope + get(f'{block}.norm.bias')
        weight = weight.contiguous(memory_format=memory).requires_grad_()
        self.weights[block if folds else name] = (weight, bias.requires_grad_(not folds))

    def convolve(self, name, x, stride=1, dilation=1):
        weight, bias = self.weights[name]
        padding = dilation * (weight.shape[2] // 2)
        return functional.conv2d(x, weight, bias, stride, padding, dilation)

    def block(self, name, x, stride=1):
        return functional.relu(self.convolve(name, x, stride), inplace=True)

    def residual(self, name, x, dilation=1):
        return functional.relu(x + self.convolve(name, x, 1, dilation), inplace=True)

    def top_down(self, name, fine, coarse):
        """Pixel i of the result lies on coarse position i / 2: one more row and column, half of
        which are cut away."""
        coarse = functional.pad(self.convolve(name, coarse), (0, 1, 0, 1), 'replicate')
        size = [2 * side - 1 for side in coarse.shape[2:]]
        up = functional.interpolate(coarse, size=size, mode='bilinear', align_corners=True)
        return fine + up[:, :, :fine.shape[2], :fine.shape[3]]

    def output(self, name, x):
        y = self.convolve(name, x)
        return y * torch.rsqrt((y * y).sum(1, keepdim=True) + SMALLEST_SQUARE)

    def forward(self, x):
        c2 = self.block('half', self.block('half_down', x, 2))
        c4 = self.residual('quarter', self.block('quarter_down', c2, 2))
        wide = self.residual('eighth', self.block('eighth_down', c4, 2))
        c8 = self.residual('eighth_dilated', wide, 2)
        c16 = self.residual('sixteenth', self.block('sixteenth_down', c8, 2))
        t8 = self.top_down('sixteenth_to_eighth', c8, c16)
        t4 = self.top_down('eighth_to_quarter', c4, t8)
        t2 = self.top_down('quarter_to_half', c2, t4)
        return [self.output('half_output', t2), self.output('quarter_output', t4),
                self.output('eighth_output', t8), self.output('sixteenth_output', c16)]

    def parameters(self):
        return [p for pair in self.weights.values() for p in pair if p.requires_grad]


def encoder(words, memory):
    n, h, w = map(int, words[1:4])
    net = Encoder(words[0], memory)
    pattern = torch.arange(n * h * w * 2) * 31 % 97 / 48 - 1
    x = pattern.reshape(n, h, w, 2).permute(0, 3, 1, 2).contiguous(memory_format=memory)

    def forward():
        with torch.inference_mode():
            return net.forward(x)

    def both():
        loss = sum(features.sum() for features in net.forward(x))
        return torch.autograd.grad(loss, net.parameters())

    return forward if words[4] == 'forward' else both


def checksum(features):
    numbers = features.permute(0, 2, 3, 1).reshape(-1).double()
    return float((numbers * (torch.arange(len(numbers)) % 13 - 6)).sum())


def main():
    call = None
    for line in sys.stdin:
        task, *words = line.split()
        answer = ['ready']
        if task == 'threads':
            torch.set_num_threads(int(words[0]))
        elif task == 'time':
            answer = [repr(t) for t in timed(call, int(words[0]))]
        else:
            prepare = {'convolution': convolution, 'encoder': encoder}[task]
            call = min((prepare(words, memory) for memory in FORMATS),
                       key=lambda candidate: min(timed(candidate, 5)))
            if task == 'encoder' and words[-1] == 'forward':
                answer += [repr(checksum(features)) for features in call()]
        print(*answer, flush=True)


main()
