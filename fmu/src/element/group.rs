//! Loops over the elements, several at a time in the lanes of the machine's vectors.

use super::History;
use super::assembly::{AssemblyMap, Inadmissible};
use super::geometry::{ElementGeometry, Geometry};
use super::kernel::PointState;
use super::shape::POINTS;
use crate::law::Voigt;
use crate::mesh::UNKNOWNS;
use crate::number::{Lanes, PACKET, Packet, closure};
use pulp::Simd;
use std::ops::Range;

/// What is done to every element.
pub(super) trait ElementLoop {
    /// Does it to a group of elements, all or none; `None` when one of them cannot be evaluated.
    fn group<S: Simd>(&mut self, group: &Group<S>) -> Option<()>;

    /// Does it to all `elements`, compiled for the machine's vector instructions.
    ///
    /// # Errors
    /// The first element that cannot be evaluated.
    fn run(mut self, elements: usize) -> Result<(), Inadmissible>
    where
        Self: Sized,
    {
        pulp::Arch::new().dispatch(Groups { work: &mut self, elements: 0..elements })
    }
}

/// A loop over some elements.
pub(super) struct Groups<'a, L> {
    pub work: &'a mut L,
    pub elements: Range<usize>,
}

impl<L: ElementLoop> pulp::WithSimd for Groups<'_, L> {
    type Output = Result<(), Inadmissible>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { work, elements: Range { start, end } } = self;
        for first in (start..end).step_by(Lanes::<S>::COUNT) {
            let group = Group { simd, first, end };
            if work.group(&group).is_none() {
                one_by_one(work, group.elements())?;
            }
        }
        Ok(())
    }
}

/// Among the elements is one that cannot be evaluated: finds it.
#[cold]
#[inline(never)]
fn one_by_one<L: ElementLoop>(work: &mut L, elements: Range<usize>) -> Result<(), Inadmissible> {
    let end = elements.end;
    for element in elements {
        let group = Group { simd: pulp::Scalar, first: element, end };
        work.group(&group).ok_or(Inadmissible { element })?;
    }
    Ok(())
}

/// As many consecutive elements as there are lanes; the last group is filled up with its last element.
#[derive(Clone, Copy)]
pub(super) struct Group<S> {
    simd: S,
    first: usize,
    end: usize,
}

impl<S: Simd> Group<S> {
    /// The elements, each once.
    #[inline(always)]
    pub fn elements(&self) -> Range<usize> {
        self.first..self.end.min(self.first + Lanes::<S>::COUNT)
    }

    /// Place of their packet.
    #[inline(always)]
    pub fn packet(&self) -> usize {
        self.first / PACKET
    }

    /// Places of the lanes in their packet.
    #[inline(always)]
    pub fn places(&self) -> Range<usize> {
        self.first % PACKET..self.first % PACKET + Lanes::<S>::COUNT
    }

    /// A number in every lane.
    #[inline(always)]
    pub fn splat(&self, value: f64) -> Lanes<S> {
        Lanes::splat(self.simd, value)
    }

    /// The lanes' part of a packet.
    #[inline(always)]
    pub fn load(&self, packet: &Packet) -> Lanes<S> {
        Lanes::load(self.simd, packet, self.first % PACKET / Lanes::<S>::COUNT)
    }

    /// Writes the lanes' part of a packet.
    #[inline(always)]
    pub fn store(&self, lanes: Lanes<S>, packet: &mut Packet) {
        packet.0[self.places()].copy_from_slice(lanes.as_slice());
    }

    /// The lanes' part of a tensor's packets.
    #[inline(always)]
    pub fn load_tensor(&self, tensor: &Voigt<Packet>) -> Voigt<Lanes<S>> {
        let [a, b, c, d] = tensor;
        [self.load(a), self.load(b), self.load(c), self.load(d)]
    }

    /// Writes the lanes' part of a tensor's packets.
    #[inline(always)]
    pub fn store_tensor(&self, lanes: Voigt<Lanes<S>>, tensor: &mut Voigt<Packet>) {
        for (lanes, packet) in lanes.into_iter().zip(tensor) {
            self.store(lanes, packet);
        }
    }

    /// One number per element.
    #[inline(always)]
    pub fn gather(&self, value: impl Fn(usize) -> f64) -> Lanes<S> {
        let last = self.end - 1;
        Lanes::from_fn(self.simd, closure!(|lane: usize| value(last.min(self.first + lane))))
    }

    /// Geometry of the packet.
    #[inline(always)]
    pub fn geometry<'a>(&self, geometry: &'a Geometry) -> &'a ElementGeometry<Packet> {
        &geometry.packets[self.packet()]
    }

    /// The elements' unknowns.
    #[inline(always)]
    pub fn unknowns(&self, map: &AssemblyMap, x: &[f64]) -> [Lanes<S>; UNKNOWNS] {
        let mut own = [self.splat(0.0); UNKNOWNS];
        for (i, own) in own.iter_mut().enumerate() {
            *own = self.gather(closure!(|element: usize| x[map.unknowns[element][i] as usize]));
        }
        own
    }

    /// Adds each element's numbers to those of its unknowns.
    #[inline(always)]
    pub fn scatter(&self, map: &AssemblyMap, own: &[Lanes<S>; UNKNOWNS], into: &mut [f64]) {
        for (lane, element) in self.elements().enumerate() {
            for (&unknown, own) in map.unknowns[element].iter().zip(own) {
                into[unknown as usize] += own.as_slice()[lane];
            }
        }
    }

    /// The elements' history.
    #[inline(always)]
    pub fn history(&self, old: &History) -> GroupHistory<S> {
        let zero = self.splat(0.0);
        let tensors = old.tensors::<4>().len() / old.jacobian.len() * POINTS;
        let mut group = GroupHistory {
            jacobian: [zero; POINTS],
            cv_inverse: vec![[zero; 4]; tensors],
            past_strain: vec![zero; if old.past_strain.is_empty() { 0 } else { POINTS }],
        };
        for (k, jacobian) in group.jacobian.iter_mut().enumerate() {
            *jacobian = self.gather(closure!(|element: usize| old.jacobian[element * POINTS + k]));
        }
        let all = old.tensors::<4>();
        for (k, cv_inverse) in group.cv_inverse.iter_mut().enumerate() {
            for (i, component) in cv_inverse.iter_mut().enumerate() {
                *component = self.gather(closure!(|element: usize| all[element * tensors + k][i]));
            }
        }
        for (k, past) in group.past_strain.iter_mut().enumerate() {
            *past = self.gather(closure!(|element: usize| old.past_strain[element * POINTS + k]));
        }
        group
    }
}

/// History of a group's elements.
pub(super) struct GroupHistory<S: Simd> {
    pub jacobian: [Lanes<S>; POINTS],
    pub cv_inverse: Vec<Voigt<Lanes<S>>>,
    pub past_strain: Vec<Lanes<S>>,
}

impl<S: Simd> GroupHistory<S> {
    /// As the kernel reads it.
    #[inline(always)]
    pub fn state(&self) -> PointState<'_, Lanes<S>> {
        PointState { jacobian: &self.jacobian, cv_inverse: &self.cv_inverse, past_strain: &self.past_strain }
    }

    /// Writes it back.
    #[inline(always)]
    pub fn store(&self, group: &Group<S>, into: &mut History) {
        let tensors = self.cv_inverse.len();
        for (lane, element) in group.elements().enumerate() {
            let first = element * POINTS;
            for (k, jacobian) in self.jacobian.iter().enumerate() {
                into.jacobian[first + k] = jacobian.as_slice()[lane];
            }
            for (k, cv_inverse) in self.cv_inverse.iter().enumerate() {
                for (i, component) in cv_inverse.iter().enumerate() {
                    into.tensors_mut::<4>()[element * tensors + k][i] = component.as_slice()[lane];
                }
            }
            for (k, past) in self.past_strain.iter().enumerate() {
                into.past_strain[first + k] = past.as_slice()[lane];
            }
        }
    }
}
