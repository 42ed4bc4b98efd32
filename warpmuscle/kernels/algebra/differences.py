"""Differences on a GPU that come out the same in every kernel.

In a b - c d one product can be fused with the subtraction, and not rounded. Where a GPU's code is put together from
PTX, that is decided by what else is computed nearby: the same equation then has other last bits with 32 lanes an
instance than with 16. In a b + (-c d) the first is fused, and that is decided before. The minus is an instruction of
its own here, so that the compiler does not make a difference of it again; it vanishes into the one that reads it.

Kernels on a CPU are not concerned: an instance has one lane there.
"""

DIFFERENCES = """
namespace wp {
inline CUDA_CALLABLE float minus(float x)
{
    float negative;
    asm("neg.f32 %0, %1;" : "=f"(negative) : "f"(x));
    return negative;
}
inline CUDA_CALLABLE double minus(double x)
{
    double negative;
    asm("neg.f64 %0, %1;" : "=d"(negative) : "d"(x));
    return negative;
}
template <typename A, typename B> inline CUDA_CALLABLE auto difference(const A& a, const B& b) { return sub(a, b); }
inline CUDA_CALLABLE float difference(float a, float b) { return a + minus(b); }
inline CUDA_CALLABLE double difference(double a, double b) { return a + minus(b); }
template <unsigned Length, typename T>
inline CUDA_CALLABLE vec_t<Length, T> difference(const vec_t<Length, T>& a, const vec_t<Length, T>& b)
{
    vec_t<Length, T> result;
    for (unsigned i = 0; i < Length; ++i)
        result.c[i] = difference(a.c[i], b.c[i]);
    return result;
}
template <unsigned Rows, unsigned Columns, typename T>
inline CUDA_CALLABLE mat_t<Rows, Columns, T> difference(
    const mat_t<Rows, Columns, T>& a, const mat_t<Rows, Columns, T>& b)
{
    mat_t<Rows, Columns, T> result;
    for (unsigned i = 0; i < Rows; ++i)
        for (unsigned j = 0; j < Columns; ++j)
            result.data[i][j] = difference(a.data[i][j], b.data[i][j]);
    return result;
}
inline CUDA_CALLABLE vec_t<3, float> neg(const vec_t<3, float>& v)
{
    return vec_t<3, float>(minus(v.c[0]), minus(v.c[1]), minus(v.c[2]));
}
inline CUDA_CALLABLE mat_t<3, 3, float> skew(const vec_t<3, float>& v)
{
    vec_t<3, float> w = neg(v);
    return mat_t<3, 3, float>(0.0f, w.c[2], v.c[1], v.c[2], 0.0f, w.c[0], w.c[1], v.c[0], 0.0f);
}
inline CUDA_CALLABLE vec_t<3, float> cross(vec_t<3, float> a, vec_t<3, float> b)
{
    return vec_t<3, float>(
        difference(a.c[1] * b.c[2], a.c[2] * b.c[1]), difference(a.c[2] * b.c[0], a.c[0] * b.c[2]),
        difference(a.c[0] * b.c[1], a.c[1] * b.c[0]));
}
inline CUDA_CALLABLE quat_t<float> quat_inverse(const quat_t<float>& q)
{
    return quat_t<float>(minus(q.x), minus(q.y), minus(q.z), q.w);
}
inline CUDA_CALLABLE quat_t<float> mul(const quat_t<float>& a, const quat_t<float>& b)
{
    return quat_t<float>(
        difference(a.w * b.x + b.w * a.x + a.y * b.z, b.y * a.z),
        difference(a.w * b.y + b.w * a.y + a.z * b.x, b.z * a.x),
        difference(a.w * b.z + b.w * a.z + a.x * b.y, b.x * a.y),
        difference(difference(difference(a.w * b.w, a.x * b.x), a.y * b.y), a.z * b.z));
}
inline CUDA_CALLABLE vec_t<3, float> turned(const quat_t<float>& q, const vec_t<3, float>& v, float across)
{
    float along = difference(2.0f * q.w * q.w, 1.0f);
    float share = 2.0f * (q.x * v.c[0] + q.y * v.c[1] + q.z * v.c[2]);
    vec_t<3, float> side = cross(vec_t<3, float>(q.x, q.y, q.z), v);
    return vec_t<3, float>(
        v.c[0] * along + q.x * share + side.c[0] * across, v.c[1] * along + q.y * share + side.c[1] * across,
        v.c[2] * along + q.z * share + side.c[2] * across);
}
inline CUDA_CALLABLE vec_t<3, float> quat_rotate(const quat_t<float>& q, const vec_t<3, float>& v)
{
    return turned(q, v, 2.0f * q.w);
}
inline CUDA_CALLABLE vec_t<3, float> quat_rotate_inv(const quat_t<float>& q, const vec_t<3, float>& v)
{
    return turned(q, v, -2.0f * q.w);
}
}
#define sub difference
"""
