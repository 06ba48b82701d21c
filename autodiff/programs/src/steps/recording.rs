//! The methods of [`Program`] that record operations.

use super::added::AddedOperation;
use super::checks::Shape;
use super::mapped::{AnyKernel, Arrays, Edges, Mapped, OfElements, handles};
use super::operation::StepOperation;
use super::program::Program;
use crate::arrays::{AddedArrays, Array, ArrayOperation, Gather, Kernel, Layer, Matrix, Parameter};

/// The operations. Each method panics if an array or a matrix belongs to another program. It cannot detect this if this
/// program has an array or a matrix of the same shape at the same position in memory.
impl Program {
    #[track_caller]
    fn assert_known_matrix(&self, matrix: Matrix) {
        let known = self.parameters.get(matrix.parameter);
        let is_known = matches!(known, Some(Parameter::Matrix(m)) if *m == matrix);
        assert!(
            is_known,
            "this matrix belongs to another program; use only matrices that this program returned"
        );
    }

    /// Maps a kernel over arrays of equal length: element `k` of each output is a result of the kernel at elements `k`
    /// of `x`. `uniforms` are arrays of one number, one for each [uniform input](Kernel::UNIFORMS) of the kernel, which all
    /// elements share. The cotangent of a uniform input is the sum over all elements, in their order. It is only computed
    /// for inputs that carry derivatives.
    ///
    /// # Panics
    /// If the arrays differ in length, if one belongs to another program, if the kernel has no inputs or no results, if
    /// `uniforms` does not have one array for each uniform input of the kernel, or if one of these arrays does not have
    /// exactly one number.
    #[track_caller]
    pub fn map<K, const I: usize, const O: usize>(
        &mut self,
        kernel: K,
        x: [Array; I],
        uniforms: &[Array],
    ) -> [Array; O]
    where
        K: Kernel<I, O>,
    {
        let shape = Shape::of::<K, I, O>();
        let len = self.known().check_map(&x, uniforms, shape);
        let outputs = self.outputs(len, O);
        self.push_kernel(OfElements::<K, I, O>(kernel), [&x, uniforms], outputs, None)
    }

    /// Records a kernel. `read` are its inputs and its uniform inputs.
    #[track_caller]
    pub(super) fn push_kernel<const O: usize>(
        &mut self,
        kernel: impl AnyKernel,
        [inputs, uniforms]: [&[Array]; 2],
        outputs: Vec<Array>,
        edges: Option<Edges>,
    ) -> [Array; O] {
        let results = handles(&outputs);
        let arrays = Arrays {
            inputs: inputs.to_vec(),
            uniforms: uniforms.to_vec(),
            outputs,
            edges,
        };
        let kernel = Mapped::new(kernel, arrays);
        self.operations.push(StepOperation::Kernel(kernel));
        results
    }

    /// Records a dense layer, `matrix * (x_0, x_1, ...) + bias`. The arrays of `x` are joined into one vector.
    ///
    /// # Panics
    /// If the total length of the arrays of `x` is not the number of columns of the matrix, if the length of `bias` is
    /// not the number of rows, or if an array or the matrix belongs to another program.
    #[track_caller]
    pub fn dense(&mut self, matrix: Matrix, x: &[Array], bias: Array) -> Array {
        self.dense_layer(matrix, x, bias, false)
    }

    /// Records a dense layer with an activation, `y = tanh(matrix * (x_0, x_1, ...) + bias)`. In all modes of
    /// differentiation, the slope of `tanh` is computed from the result as `1 - y^2`. The function
    /// [`layer_tanh`](autodiff::Real::layer_tanh) does the same.
    ///
    /// # Panics
    /// Like [`dense`](Program::dense).
    #[track_caller]
    pub fn dense_tanh(&mut self, matrix: Matrix, x: &[Array], bias: Array) -> Array {
        self.dense_layer(matrix, x, bias, true)
    }

    #[track_caller]
    fn dense_layer(&mut self, matrix: Matrix, x: &[Array], bias: Array, tanh: bool) -> Array {
        self.known().check(x);
        self.known().check(&[bias]);
        self.assert_known_matrix(matrix);
        let columns: usize = x.iter().map(|a| a.len()).sum();
        assert_eq!(
            columns, matrix.columns,
            "dense: the arrays of `x` together must have one number for each column of the matrix"
        );
        assert_eq!(
            bias.len(),
            matrix.rows,
            "dense: `bias` must have one number for each row of the matrix"
        );
        let output = self.output(matrix.rows);
        let layer = Layer {
            matrix,
            x: x.to_vec(),
            bias,
            output,
            tanh,
        };
        self.operations.push(StepOperation::Dense(layer));
        output
    }

    /// Returns an array of `x[index]` for every index, with zero for `None`. For example, `&[Some(0); 8]` makes eight
    /// copies of the first number.
    ///
    /// # Panics
    /// If an index is out of range, or the array belongs to another program.
    #[track_caller]
    pub fn gather(&mut self, x: Array, indices: &[Option<usize>]) -> Array {
        self.known().check_gather(x, indices);
        let output = self.output(indices.len());
        let gather = Gather::new(x, indices, output);
        self.operations.push(StepOperation::Gather(gather));
        output
    }

    /// Records an operation of your crate that reads the arrays of `x`. Returns its outputs, which have the lengths `lens`.
    ///
    /// # Panics
    /// If the operation has no outputs, or an array belongs to another program.
    #[track_caller]
    pub fn operation(
        &mut self,
        operation: impl ArrayOperation,
        x: &[Array],
        lens: &[usize],
    ) -> Vec<Array> {
        self.known().check(x);
        assert!(
            !lens.is_empty(),
            "operation: an operation must have at least one output"
        );
        self.align(false);
        let outputs = lens.iter().map(|&len| self.unaligned_output(len));
        let outputs: Vec<Array> = outputs.collect();
        let arrays = AddedArrays {
            inputs: x.to_vec(),
            outputs: outputs.clone(),
        };
        let added = AddedOperation::new(operation, arrays);
        self.operations.push(StepOperation::Added(added));
        outputs
    }
}
