//! Objects of JavaScript.

use js_sys::{Array, Reflect};
use wasm_bindgen::JsValue;

/// An object in the making.
pub struct Object(JsValue);

impl Object {
    /// One without properties.
    pub fn new() -> Self {
        Self(js_sys::Object::new().into())
    }

    /// With one more property.
    pub fn with(self, key: &str, value: impl Into<JsValue>) -> Self {
        // It fails for what is no object, or frozen.
        let _ = Reflect::set(&self.0, &key.into(), &value.into());
        self
    }
}

impl From<js_sys::Error> for Object {
    fn from(error: js_sys::Error) -> Self {
        Self(error.into())
    }
}

impl From<Object> for JsValue {
    fn from(object: Object) -> Self {
        object.0
    }
}

/// A list.
pub fn list<T: Into<JsValue>>(items: impl IntoIterator<Item = T>) -> JsValue {
    items.into_iter().map(Into::into).collect::<Array>().into()
}

/// What may be missing.
pub fn or_null<T: Into<JsValue>>(value: Option<T>) -> JsValue {
    value.map_or(JsValue::NULL, Into::into)
}
