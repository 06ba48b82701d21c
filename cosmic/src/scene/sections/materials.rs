//! Settings of the materials of bars: plain numbers, or parts such as tubes, joints and actuators from a shop.

use std::f64::consts::PI;

use crate::lattice::{Lattice, Material};
use crate::scene::Scene;
use crate::settings;
use crate::settings::{Filled, Limits, Named, SettingValue, above, within};
use toml::Spanned;
use toml::de::DeValue;

settings! {
    /// The library of materials, each array in the order void, skeleton, actuator.
    struct MaterialSettings with parts: PartsSettings {
        /// Stiffness of void, skeleton, actuator.
        stiffness: [f64; 3] = [1e-7, 4e2, 3e1], allowed within(0.0, 1e9), unit "N/m",
            source "paper, table 1";
        /// Mass per length of void, skeleton, actuator.
        density: [f64; 3] = [1e-8, 0.030, 0.100], allowed within(0.0, 1e6), unit "kg/m",
            source "paper, table 1";
        /// Largest actuation strain of void, skeleton, actuator. Only the last one is used, because only the actuator
        /// share of an edge acts.
        max_strain: [f64; 3] = [0.0, 0.0, 0.35], allowed within(0.0, 0.99),
            source "paper, table 1; D8";
        /// Exponent on the shares of a mixture in its stiffness (the penalisation of SIMP).
        penalisation: usize = 1, allowed within(1.0, 10.0), source "paper: 1, none";
    }
}

settings! {
    /// Parts that can be bought or printed. A bar of skeleton is a tube, a rod or a strut of a real material; a bar of
    /// actuator is a device of a given mass and stroke. Stiffness and mass follow from the bar's rest length.
    struct PartsSettings {
        /// What a bar of skeleton is: the plain numbers of `[materials]`, or a tube, a round rod or a printed strut with a
        /// square section.
        skeleton: SkeletonPart = SkeletonPart::Numbers, source "paper: numbers";
        /// Material of the parts of skeleton. "carbon": 134 GPa and 1500 kg/m3 (pultruded tubes, Goodwinds). "glass": 41 GPa
        /// and 2000 kg/m3 (pultruded rods, Goodwinds). "aluminium": 69 GPa and 2700 kg/m3 (alloy 6061, makeitfrom.com).
        /// "steel": 200 GPa and 7800 kg/m3 (AISI 304, makeitfrom.com). "pla": 3.0 GPa and 1260 kg/m3 (Stratasys PLA,
        /// printed on edge). Your own material is `[modulus, density]`, such as `[2e9, 900]` for 2 GPa and 900
        /// kg/m3.
        material: PartMaterial = PartMaterial::Stock(StockMaterial::Carbon), allowed above(0.0, 1e13),
            read "with a tube, a rod or a strut" if Scene::has_sections,
            source "beyond the paper";
        /// Outer diameter of a tube, diameter of a rod, or width of a strut.
        outer: f64 = 0.006, allowed above(0.0, 1.0), unit "m",
            read "with a tube, a rod or a strut" if Scene::has_sections,
            source "beyond the paper";
        /// Inner diameter of a tube.
        inner: f64 = 0.004, allowed within(0.0, 1.0), unit "m",
            read "with a tube" if |s: &Scene| s.materials.parts.skeleton == SkeletonPart::Tube,
            source "beyond the paper";
        /// Stiffness of one joint along its bar. Every part and every device has a joint at either end; "off": rigid.
        joint: Option<f64> = None, allowed above(0.0, 1e12), unit "N/m",
            read "with parts" if |s: &Scene| s.materials.parts.are_used(),
            source "beyond the paper";
        /// Mass of the fitting at one end of a part or a device, such as a rod end.
        end_mass: f64 = 0.0, allowed within(0.0, 1e3), unit "kg",
            read "with parts" if |s: &Scene| s.materials.parts.are_used(),
            source "beyond the paper";
        /// What a bar of actuator is: the plain numbers of `[materials]`, or a device with the mass `actuator_mass`. The
        /// stiffness of a device is that of `materials.stiffness`, in series with its two joints.
        actuator: ActuatorPart = ActuatorPart::Numbers, source "paper: numbers";
        /// Mass of a device with the piece that extends it to the length of its bar, without `end_mass`.
        actuator_mass: f64 = 0.04, allowed above(0.0, 1e3), unit "kg",
            read "with a device" if |s: &Scene| s.materials.parts.actuator == ActuatorPart::Device,
            source "data sheet";
        /// Stroke of a device. A scene is refused if the longest bar needs more for its largest actuation strain in both
        /// directions.
        stroke: f64 = 0.05, allowed above(0.0, 10.0), unit "m",
            read "with a device" if |s: &Scene| s.materials.parts.actuator == ActuatorPart::Device,
            source "data sheet";
        /// Smallest length of a device, from joint to joint, which the verdict compares with the bars.
        length: Option<f64> = None, allowed above(0.0, 10.0), unit "m",
            read "with a device" if |s: &Scene| s.materials.parts.actuator == ActuatorPart::Device,
            source "data sheet";
        /// Largest force of a device, which the verdict compares with the walk; "off": that of the law `actuator`.
        force: Option<f64> = None, allowed above(0.0, 1e6), unit "N",
            read "with a device" if |s: &Scene| s.materials.parts.actuator == ActuatorPart::Device,
            source "data sheet";
        /// Largest speed of a device, which the verdict compares with the walk; "off": that of the law `actuator`.
        speed: Option<f64> = None, allowed above(0.0, 1e3), unit "m/s",
            read "with a device" if |s: &Scene| s.materials.parts.actuator == ActuatorPart::Device,
            source "data sheet";
        /// Bore of a pneumatic cylinder; "off": the device needs no air. Reports then say how much air the robot needs.
        bore: Option<f64> = None, allowed above(0.0, 1.0), unit "m",
            read "with a device" if |s: &Scene| s.materials.parts.actuator == ActuatorPart::Device,
            source "data sheet";
        /// Pressure of the air in a cylinder, above that of the atmosphere.
        pressure: f64 = 6e5, allowed above(0.0, 1e8), unit "Pa",
            read "with a bore" if |s: &Scene| s.materials.parts.cylinder().is_some(),
            source "beyond the paper";
    }
}

settings! {
    /// What a bar of skeleton is.
    #[derive(Default)]
    enum SkeletonPart {
        /// Its stiffness and its mass per length are plain numbers.
        #[default]
        Numbers = "numbers",
        /// A round tube.
        Tube = "tube",
        /// A round rod.
        Rod = "rod",
        /// A printed strut with a square section.
        Strut = "strut",
    }
}

settings! {
    /// A material of parts that shops sell.
    enum StockMaterial {
        /// Pultruded carbon fibre.
        Carbon = "carbon",
        /// Pultruded glass fibre.
        Glass = "glass",
        /// Aluminium 6061.
        Aluminium = "aluminium",
        /// Stainless steel AISI 304.
        Steel = "steel",
        /// Printed PLA.
        Pla = "pla",
    }
}

/// The material of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PartMaterial {
    /// A material that shops sell.
    Stock(StockMaterial),
    /// A material that the user describes: Young's modulus (Pa) and density (kg/m3).
    Own([f64; 2]),
}

impl PartMaterial {
    /// The name of the material; "own" for a material that the user describes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stock(stock) => stock.name(),
            Self::Own(_) => "own",
        }
    }

    /// Young's modulus (Pa) and density (kg/m3). The documentation of the key `material` has the sources.
    fn modulus_and_density(self) -> [f64; 2] {
        match self {
            Self::Stock(StockMaterial::Carbon) => [134e9, 1500.0],
            Self::Stock(StockMaterial::Glass) => [41e9, 2000.0],
            Self::Stock(StockMaterial::Aluminium) => [69e9, 2700.0],
            Self::Stock(StockMaterial::Steel) => [200e9, 7800.0],
            Self::Stock(StockMaterial::Pla) => [3.0e9, 1260.0],
            Self::Own(own) => own,
        }
    }
}

impl SettingValue for PartMaterial {
    fn allowed(&self, limits: &Limits) -> String {
        let stock = StockMaterial::Carbon.allowed(limits);
        format!("{stock} or [modulus, density], each a number {limits}")
    }

    fn toml(&self) -> String {
        match self {
            Self::Stock(stock) => stock.toml(),
            Self::Own(own) => own.toml(),
        }
    }

    fn json(&self) -> serde_json::Value {
        match self {
            Self::Stock(stock) => stock.json(),
            Self::Own(own) => own.json(),
        }
    }

    fn read(&mut self, value: &Spanned<DeValue>, limits: &Limits) -> Filled<()> {
        *self = if value.get_ref().is_array() {
            let mut own = [0.0; 2];
            own.read(value, limits)?;
            Self::Own(own)
        } else {
            let mut stock = StockMaterial::Carbon;
            stock.read(value, limits)?;
            Self::Stock(stock)
        };
        Ok(())
    }

    fn fits(&self, limits: &Limits) -> bool {
        match self {
            Self::Stock(_) => true,
            Self::Own(own) => own.fits(limits),
        }
    }
}

settings! {
    /// What a bar of actuator is.
    #[derive(Default)]
    enum ActuatorPart {
        /// Its stiffness and its mass per length are plain numbers.
        #[default]
        Numbers = "numbers",
        /// A device from a shop, of a given mass and stroke.
        Device = "device",
    }
}

/// The pressure of the atmosphere at which a volume of air is stated, Pa.
const ATMOSPHERE: f64 = 1e5;

/// The section of a bar.
#[derive(Clone, Copy)]
struct Section {
    /// Area, m^2.
    area: f64,
    /// Second moment of area, m^4.
    second_moment: f64,
}

impl Section {
    /// A disc with this diameter, m.
    fn disc(diameter: f64) -> Self {
        Self {
            area: PI / 4.0 * diameter.powi(2),
            second_moment: PI / 64.0 * diameter.powi(4),
        }
    }

    /// A square with sides of this length, m.
    fn square(side: f64) -> Self {
        Self {
            area: side.powi(2),
            second_moment: side.powi(4) / 12.0,
        }
    }

    /// This section with a hole of the shape `hole` in its middle.
    fn without(self, hole: Self) -> Self {
        Self {
            area: self.area - hole.area,
            second_moment: self.second_moment - hole.second_moment,
        }
    }
}

impl PartsSettings {
    /// The section of a part of skeleton; `None` for plain numbers.
    fn section(&self) -> Option<Section> {
        match self.skeleton {
            SkeletonPart::Numbers => None,
            SkeletonPart::Tube => {
                Some(Section::disc(self.outer).without(Section::disc(self.inner)))
            }
            SkeletonPart::Rod => Some(Section::disc(self.outer)),
            SkeletonPart::Strut => Some(Section::square(self.outer)),
        }
    }

    /// The bore of the cylinders (m); `None` if actuators need no air.
    pub(in crate::scene) fn cylinder(&self) -> Option<f64> {
        let is_device = self.actuator == ActuatorPart::Device;
        self.bore.filter(|_| is_device)
    }

    /// The air that cylinders take from the supply while their lengths change by `travel` (m) in total, as a volume at 1
    /// bar (m^3): each movement fills a chamber at the absolute pressure. `None` if actuators need no air.
    pub fn air(&self, travel: f64) -> Option<f64> {
        let area = Section::disc(self.cylinder()?).area;
        Some(travel * area * (self.pressure + ATMOSPHERE) / ATMOSPHERE)
    }

    /// The least power (W) that compresses air to the pressure of the cylinders: the isothermal work. `air` is its volume
    /// at 1 bar per second (m^3/s).
    pub fn air_power(&self, air: f64) -> f64 {
        ATMOSPHERE * air * (self.pressure / ATMOSPHERE).ln_1p()
    }

    /// True if bars of skeleton or of actuator are parts.
    fn are_used(&self) -> bool {
        self.skeleton != SkeletonPart::Numbers || self.actuator != ActuatorPart::Numbers
    }

    /// The stiffness of a bar (N/m) whose own stiffness is `stiffness`, with a joint at either end.
    fn between_joints(&self, stiffness: f64) -> f64 {
        match self.joint {
            Some(joint) => (stiffness.recip() + 2.0 / joint).recip(),
            None => stiffness,
        }
    }

    /// Checks that these parts can be made.
    ///
    /// # Errors
    /// A sentence that says what is wrong.
    pub(crate) fn check(&self) -> Result<(), String> {
        let (outer, inner) = (self.outer, self.inner);
        if self.skeleton == SkeletonPart::Tube && inner >= outer {
            return Err(format!(
                "the inner diameter of a tube ({inner} m) must be smaller than its outer diameter ({outer} m)"
            ));
        }
        Ok(())
    }
}

/// The numbers of the bar of an edge, for each material in the order void, skeleton, actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BarNumbers {
    /// Stiffness, N/m.
    pub stiffness: [f64; 3],
    /// Mass divided by rest length, kg/m.
    pub density: [f64; 3],
}

impl MaterialSettings {
    /// The largest strain of an actuator; 0 if actuators do not move.
    pub fn actuator_strain(&self) -> f64 {
        Material::Actuator.of(&self.max_strain)
    }

    /// The largest strain of an actuator, by which laws tell the share of actuator in an edge. It is 1 if actuators do not
    /// move.
    pub fn largest_strain(&self) -> f64 {
        match self.actuator_strain() {
            0.0 => 1.0,
            strain => strain,
        }
    }

    /// The stiffness and the mass per length of a bar with this rest length (m). They depend on the length only if the
    /// scene has [parts](PartsSettings).
    pub fn of_length(&self, length: f64) -> BarNumbers {
        let (mut stiffness, mut density) = (self.stiffness, self.density);
        let ([_, skeleton, actuator], [_, of_skeleton, of_actuator]) =
            (&mut stiffness, &mut density);
        let parts = &self.parts;
        let ends = 2.0 * parts.end_mass / length;
        if let Some(section) = parts.section() {
            let [modulus, density] = parts.material.modulus_and_density();
            *skeleton = parts.between_joints(modulus * section.area / length);
            *of_skeleton = density * section.area + ends;
        }
        if parts.actuator == ActuatorPart::Device {
            *actuator = parts.between_joints(*actuator);
            *of_actuator = parts.actuator_mass / length + ends;
        }
        BarNumbers { stiffness, density }
    }

    /// The stiffness and the mass per length of the bar of an edge. A truss may give its stiffness, for both solid
    /// materials.
    pub fn of_edge(&self, lattice: &Lattice, edge: usize) -> BarNumbers {
        let mut bar = self.of_length(lattice.rest_length[edge]);
        if let Some(&given) = lattice.stiffness.get(edge) {
            let [_, solid @ ..] = &mut bar.stiffness;
            solid.fill(given);
        }
        bar
    }

    /// The force (N) under which a skeleton bar with this rest length (m) buckles: `pi^2 E I / l^2`, Euler's load of a bar
    /// with a joint at either end. `None` if skeleton has plain numbers instead of a section.
    pub fn euler_load(&self, length: f64) -> Option<f64> {
        let section = self.parts.section()?;
        let [modulus, _] = self.parts.material.modulus_and_density();
        Some(PI.powi(2) * modulus * section.second_moment / length.powi(2))
    }
}

impl Scene {
    /// True if bars of skeleton are tubes, rods or struts.
    fn has_sections(&self) -> bool {
        self.materials.parts.skeleton != SkeletonPart::Numbers
    }
}
